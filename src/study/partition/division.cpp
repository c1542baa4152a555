#include "study/partition/division.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>

#include "io/files/digest.hpp"
#include "io/files/identity.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/shell_words.hpp"
#include "io/files/visible.hpp"
#include "mechanism/error.hpp"
#include "study/partition/shard_file.hpp"

namespace freeplay {
namespace {

constexpr int format = 1;  // of the manifest
constexpr std::size_t key_letters = 32, number_letters = 12, line = key_letters + number_letters + 2;

/// The last step of SplitMix64 (Steele, Lea, Flood 2014): every bit of a checksum decides the place.
std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

std::string text_of(std::vector<Unit> units) {
  std::vector<std::pair<std::uint64_t, std::size_t>> order;
  for (std::size_t i = 0; i < units.size(); ++i) order.emplace_back(mixed(checksum(units[i].key)), i);
  std::ranges::sort(order, [&](const auto& a, const auto& b) {
    return std::pair(a.first, units[a.second].key) < std::pair(b.first, units[b.second].key);
  });
  std::string text;
  text.reserve(units.size() * line);
  for (const auto& [place, i] : order) text += fmt::format("{} {:012}\n", units[i].key, units[i].number);
  return text;
}

std::filesystem::path units_file(const std::filesystem::path& folder) {
  return shards_folder(folder) / "units.txt";
}

nlohmann::json to_json(const Manifest& m) {
  return {{"format", format},
          {"plan", m.plan},
          {"verb", m.verb},
          {"arguments", m.arguments},
          {"subject", m.subject},
          {"program", m.program},
          {"units_digest", m.units_digest},
          {"shards", m.shards},
          {"units", m.units}};
}

/// The first line in which two programs' identities differ, for people.
std::string difference(const std::string& planned, const std::string& here) {
  std::size_t at = 0;
  while (at < planned.size() && at < here.size() && planned[at] == here[at]) ++at;
  const auto line_at = [&](const std::string& text) {
    const auto begin = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
    return visible(text.substr(begin, text.find('\n', at) - begin));
  };
  return fmt::format("planned with {}; here {}", line_at(planned), line_at(here));
}

}  // namespace

std::string plan_digest(const Manifest& m) {
  return digest(fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n", m.verb, fmt::join(m.arguments, "\n"), m.subject,
                            digest(m.program), m.units_digest, m.shards));
}

std::filesystem::path shards_folder(const std::filesystem::path& folder) { return folder / "shards"; }

std::string units_digest(const std::filesystem::path& folder) { return file_checksum(units_file(folder)); }

Manifest make_plan(const Division& study, const std::filesystem::path& folder, std::size_t shards) {
  auto units = study.units();
  if (shards > units.size())
    throw SceneError(
        fmt::format("--plan {}: the study has {} units that can be made apart; ask for at most as many",
                    shards, units.size()));
  Manifest m{.plan = {},
             .verb = study.verb,
             .arguments = study.arguments,
             .subject = study.subject,
             .program = program_identity(),
             .units_digest = {},
             .shards = shards,
             .units = units.size()};
  const auto place = shards_folder(folder);
  const auto text = text_of(std::move(units));
  m.units_digest = text_checksum(text);
  m.plan = plan_digest(m);
  const auto database = folder / (study.verb + ".db");
  if (std::filesystem::exists(place / "manifest.json")) {
    const auto there = read_manifest(folder);
    if (there.plan == m.plan) return there;
    if (has_shards(place))
      throw SceneError(fmt::format(
          "{}: holds shards of another plan; give another folder with -o, or remove it", place.string()));
  } else if (std::filesystem::exists(database)) {
    throw SceneError(fmt::format("{}: holds runs that were made without a plan; give another folder with -o",
                                 database.string()));
  }
  make_folder(place);
  write_file(units_file(folder), text);
  write_whole(place / "manifest.json", to_json(m).dump(1) + "\n");
  return m;
}

namespace {

/// The file may be anyone's, and what it says is printed as commands: a verb, a study, --allow-outside, and no more
/// shards than units.
void require_said(const Manifest& m) {
  constexpr std::size_t most_units = 1'000'000'000;
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
  const auto& a = m.arguments;
  if (!std::ranges::all_of(m.verb, is_letter) || a.empty() || a[0].starts_with('-') ||
      std::ranges::any_of(a[0], is_control) || a.size() > 2 || (a.size() == 2 && a[1] != "--allow-outside") ||
      m.shards > m.units || m.units > most_units)
    throw std::runtime_error("says what no plan does");
}

/// A count as freeplay writes it. A fraction or a negative number is none, and what it would be converted to is not defined.
std::size_t count(const nlohmann::json& j, const char* key) {
  if (!j.at(key).is_number_unsigned()) throw std::runtime_error("says what no plan does");
  return j.at(key);
}

}  // namespace

Manifest read_manifest(const std::filesystem::path& folder) {
  const auto file = shards_folder(folder) / "manifest.json";
  if (std::filesystem::is_symlink(shards_folder(folder)))
    throw SceneError(
        fmt::format("{}: is a link; shards lie in a folder of their own", shards_folder(folder).string()));
  if (!std::filesystem::exists(file))
    throw SceneError(
        fmt::format("{}: nothing is planned here; freeplay VERB STUDY --plan N -o {} divides a study",
                    file.string(), folder.string()));
  const auto no_manifest = [&](const char* why) {
    return SceneError(fmt::format("{}: is no manifest of this freeplay ({}); plan into another folder",
                                  file.string(), why));
  };
  const JsonFile read(file);
  const auto& j = read.document();
  try {
    if (j.at("format") != format) throw std::runtime_error("of another freeplay");
    Manifest m{.plan = j.at("plan"),
               .verb = j.at("verb"),
               .arguments = j.at("arguments"),
               .subject = j.at("subject"),
               .program = j.at("program"),
               .units_digest = j.at("units_digest"),
               .shards = count(j, "shards"),
               .units = count(j, "units")};
    if (m.plan != plan_digest(m) || m.shards == 0) throw std::runtime_error("has been changed");
    require_said(m);
    return m;
  } catch (const nlohmann::json::exception&) {
    throw no_manifest("a value is missing, or of another kind");
  } catch (const std::runtime_error& e) {
    throw no_manifest(e.what());
  }
}

void require_same(const Manifest& m, const Division& study, const std::filesystem::path& folder) {
  const auto again = [&] {
    return fmt::format("freeplay {} {} --plan {} -o {}", study.verb, shell_words(study.arguments), m.shards,
                       shell_words({folder.string() + "-2"}));
  };
  if (const auto here = program_identity(); m.program != here)
    throw SceneError(fmt::format(
        "{}: was planned by another program or for other processors ({}); run the program of the plan, or plan anew: {}",
        shards_folder(folder).string(), difference(m.program, here), again()));
  if (m.verb != study.verb || m.arguments != study.arguments || m.subject != study.subject)
    throw SceneError(
        fmt::format("{}: the study has changed since it was planned ({} {}); take the change back, or plan "
                    "anew: {}",
                    shards_folder(folder).string(), m.verb, shell_words(m.arguments), again()));
}

std::vector<Unit> units_of(const Manifest& m, const std::filesystem::path& folder, std::size_t shard) {
  const auto at = [&](std::size_t k) { return k * m.units / m.shards; };
  const auto begin = at(shard - 1), end = at(shard);
  const auto torn = [&] {
    return SceneError(
        fmt::format("{}: is not whole; plan again into another folder", units_file(folder).string()));
  };
  std::error_code none;
  if (std::filesystem::file_size(units_file(folder), none) != m.units * line || none) throw torn();
  std::ifstream in(units_file(folder), std::ios::binary);
  std::string text((end - begin) * line, '\0');
  in.seekg(static_cast<std::streamoff>(begin * line));
  if (!in.read(text.data(), static_cast<std::streamsize>(text.size()))) throw torn();
  std::vector<Unit> units;
  for (std::size_t i = 0; i < end - begin; ++i) {
    const char* const number = text.data() + i * line + key_letters + 1;
    Unit unit{text.substr(i * line, key_letters), 0};
    if (std::from_chars(number, number + number_letters, unit.number).ptr != number + number_letters)
      throw torn();
    units.push_back(unit);
  }
  return units;
}

std::string command_for(const Manifest& m, const std::filesystem::path& folder, const std::string& what) {
  return fmt::format("freeplay {} {} {} -o {}", m.verb, shell_words(m.arguments), what,
                     shell_words({folder.string()}));
}

std::optional<Seal> read_seal(const std::filesystem::path& folder, std::size_t shard) {
  const auto file = shards_folder(folder) / fmt::format("{}.json", shard);
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const JsonFile read(file);
    const auto& j = read.document();
    return Seal{.plan = j.at("plan"),
                .file = j.at("file"),
                .checksum = j.at("checksum"),
                .bytes = count(j, "bytes"),
                .shard = count(j, "shard"),
                .shards = count(j, "shards"),
                .units = count(j, "units"),
                .failed = count(j, "failed"),
                .reasons = j.at("reasons"),
                .seconds = j.at("seconds"),
                .host = j.at("host")};
  } catch (const std::exception&) {
    return Seal{};  // a seal that is none: fault_of says so
  }
}

std::string fault_of(const Seal& seal, const Manifest& m, const std::filesystem::path& folder, bool deep) {
  if (seal.plan.empty() || seal.file.find('/') != seal.file.npos || !seal.file.ends_with(".db"))
    return "its seal is damaged";
  if (seal.plan != m.plan) return "it is of another plan, or another program's";
  const auto file = shards_folder(folder) / seal.file;
  std::error_code none;
  if (std::filesystem::is_symlink(file, none) || std::filesystem::file_size(file, none) != seal.bytes || none)
    return "its file is torn or gone";
  if (deep && file_checksum(file) != seal.checksum) return "its file is damaged";
  return {};
}

}  // namespace freeplay
