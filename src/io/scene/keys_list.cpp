#include "io/scene/keys_list.hpp"

#include <algorithm>
#include <utility>

namespace freeplay {
namespace {

void append(std::string& list, const std::string& item, const char* between) {
  if (item.empty() || list == item) return;
  list += (list.empty() ? "" : between) + item;
}

}  // namespace

std::string KeysList::shown(double x) {
  auto digits = fmt::format("{}", x);
  // Short spelling: 1e-4, neither 0.0001 nor 1e-04.
  if (x != 0 && (std::abs(x) < 1e-2 || std::abs(x) >= 1e5)) digits = fmt::format("{:e}", x);
  if (const auto e = digits.find('e'); e != digits.npos) {
    auto mantissa = digits.substr(0, e);
    while (mantissa.find('.') != mantissa.npos && (mantissa.back() == '0' || mantissa.back() == '.'))
      mantissa.pop_back();
    digits = fmt::format("{}e{}", mantissa, std::stoi(digits.substr(e + 1)));
  }
  return digits;
}

void KeysList::plain(const Key& key, std::string type, std::string fallback, std::string meaning) {
  const auto path = table_.empty() ? std::string(key.name) : fmt::format("{}.{}", table_, key.name);
  rows_.push_back({path, std::move(type), std::string(key.unit), std::move(fallback), std::move(meaning)});
}

void KeysList::add(const Key& key, std::string type, std::string fallback, std::string meaning) {
  if (!key.fallback.empty()) fallback = key.fallback;
  if (meaning.empty()) meaning = key.meaning;
  meaning += std::exchange(only_, {});
  auto kind = kind_;
  // Keys of a group are optional, because the group is.
  if (!group_.empty()) {
    if (fallback == "required") fallback = "–";
    if (key.name != group_) kind = fmt::format("{}{}with {}", kind, kind.empty() ? "" : " ", group_);
  }
  entries_.push_back({std::string(key.name), std::move(type), std::string(key.unit), std::move(fallback),
                      std::move(meaning), std::move(kind)});
}

void KeysList::close() {
  group_.clear();
  std::vector<std::string> done;
  for (std::size_t i = begin_; i < entries_.size(); ++i) {
    const auto& first = entries_[i];
    if (std::ranges::find(done, first.name) != done.end()) continue;
    done.push_back(first.name);
    struct Said {
      std::string meaning, kinds;
      std::size_t count;
    };
    std::vector<Said> said;
    SchemaKey row{fmt::format("{}.{}", table_, first.name), {}, {}, {}, {}};
    for (const auto& e : entries_) {
      if (&e < &entries_[begin_] || e.name != first.name) continue;
      if (row.type.find(e.type) == std::string::npos) append(row.type, e.type, " or ");
      if (row.unit.find(e.unit) == std::string::npos || row.unit.empty()) append(row.unit, e.unit, " or ");
      if (row.fallback.find(e.fallback) == std::string::npos) append(row.fallback, e.fallback, " or ");
      const auto same = std::ranges::find(said, e.meaning, &Said::meaning);
      if (same == said.end())
        said.push_back({e.meaning, e.kind, 1});
      else
        append(same->kinds, e.kind, ", "), ++same->count;
    }
    for (const auto& s : said) {
      const bool of_all = s.kinds.empty() || (said.size() == 1 && s.count == kinds_.size());
      append(row.meaning, of_all ? s.meaning : fmt::format("{}: {}", s.kinds, s.meaning), "; ");
    }
    rows_.push_back(std::move(row));
  }
  begin_ = entries_.size();
}

}  // namespace freeplay
