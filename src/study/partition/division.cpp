#include "study/partition/division.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>

#include "io/files/digest.hpp"
#include "io/files/escaping.hpp"
#include "io/files/identity.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "study/partition/record.hpp"
#include "study/store/database.hpp"

namespace freeplay {
namespace {

constexpr std::size_t block = 1 << 20;

/// Reads a regular file block by block. Links, FIFOs and devices were refused, since reading could
/// block.
template <class F>
void each_block(const RegularFile& from, const std::filesystem::path& file, F&& use) {
  std::vector<char> buffer(block);
  for (std::size_t used = 0;;) {
    const auto n = read(from.descriptor.number(), buffer.data() + used, buffer.size() - used);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw OutputError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(errno)));
    used += static_cast<std::size_t>(n);
    if (used == buffer.size() || (n == 0 && used > 0)) {
      use(std::string_view(buffer.data(), used));
      used = 0;
    }
    if (n == 0) return;
  }
}

RegularFile open_block_file(const std::filesystem::path& file) {
  return open_regular(file, most_of_a_database, Links::refused);
}

}  // namespace

std::string file_checksum(const std::filesystem::path& file) {
  std::string sums;
  each_block(open_block_file(file), file,
             [&](std::string_view bytes) { sums += fmt::format("{:016x}", checksum(bytes)); });
  return fmt::format("{:016x}", checksum(sums));
}

void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to) {
  const auto source = open_block_file(from);
  std::error_code none;
  const auto room = std::filesystem::space(to.parent_path(), none);
  if (!none && room.available < source.bytes)
    throw OutputError(fmt::format("{}: has {} MB of free space, but {} has {} MB", to.parent_path().string(),
                                  room.available / 1'000'000, from.string(), source.bytes / 1'000'000));
  OutputFile out(to, OutputFile::Shared());
  each_block(source, from, [&](std::string_view bytes) { out.write(bytes); });
  out.commit();
}

void copy_database(const std::filesystem::path& from, const std::filesystem::path& to) {
  Database(from, Database::Access::read).copy_to(to);
}

namespace {

constexpr std::size_t key_letters = 32, number_letters = 12, line = key_letters + number_letters + 2;

/// Last step of SplitMix64 (Steele, Lea, Flood 2014): all bits of a checksum affect the result.
std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

std::string lines_of(const std::vector<Unit>& units) {
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

/// Whether the folder contains any shard, complete or not.
bool has_shards(const std::filesystem::path& place) {
  std::error_code none;
  return std::ranges::any_of(std::filesystem::directory_iterator(place, none), [](const auto& entry) {
    const char first = entry.path().filename().string().front();
    return first >= '1' && first <= '9';
  });
}

/// First line in which two program identities differ, for messages.
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

Manifest make_plan(const Division& study, const std::filesystem::path& folder, std::size_t shards) {
  const auto units = study.units();
  if (shards > units.size())
    throw SceneError(
        fmt::format("--plan {}: the study has only {} independent units; use at most as many shards", shards,
                    units.size()));
  Manifest m{.plan = {},
             .verb = study.verb,
             .arguments = study.arguments,
             .subject = study.subject,
             .program = program_identity(),
             .units_digest = {},
             .shards = shards,
             .units = units.size()};
  const auto place = shards_folder(folder);
  const auto text = lines_of(units);
  m.units_digest = digest(text);
  m.plan = plan_digest(m);
  const auto database = folder / (study.verb + ".db");
  if (std::filesystem::exists(place / "manifest.json")) {
    const auto there = read_manifest(folder);
    if (there.plan == m.plan) return there;
    if (has_shards(place))
      throw SceneError(fmt::format(
          "{}: contains shards of another plan; give another folder with -o, or remove it", place.string()));
  } else if (std::filesystem::exists(database)) {
    throw SceneError(
        fmt::format("{}: contains runs made without a plan; give another folder with -o", database.string()));
  }
  std::string record;
  try {
    record = nlohmann::json(m).dump(1) + "\n";
  } catch (const nlohmann::json::type_error&) {
    throw SceneError(
        fmt::format("{}: the path is not UTF-8, so that a plan cannot store it; rename the folder",
                    visible(shell_words(m.arguments))));
  }
  make_folder(place);
  write_file(units_file(folder), text);
  write_file(place / "manifest.json", record, OutputFile::Shared());
  return m;
}

namespace {

/// Whether the words are a study and --allow-outside, or a scene and options of an ensemble.
bool are_arguments(const std::string& verb, const std::vector<std::string>& words) {
  constexpr std::array<std::string_view, 8> of_ensembles{"--set",  "--formulation", "--starts", "--seed",
                                                         "--turn", "--play",        "--rows",   "--column"};
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
  if (words.empty() || words[0].starts_with('-') ||
      std::ranges::any_of(words, [&](const auto& word) { return std::ranges::any_of(word, is_control); }))
    return false;
  if (verb != "ensemble") return words.size() == 1 || (words.size() == 2 && words[1] == "--allow-outside");
  for (std::size_t i = 1; i < words.size(); i += 2)
    if (std::ranges::find(of_ensembles, words[i]) == of_ensembles.end()) return false;
  return words.size() % 2 == 1;
}

/// Checks a manifest. It may be of unknown origin, and its contents are printed as commands.
void require_said(const Manifest& m) {
  constexpr std::size_t most_units = 1'000'000'000;
  const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
  if (m.format != Manifest::current) throw std::runtime_error("of another freeplay");
  if (m.plan != plan_digest(m) || m.shards == 0) throw std::runtime_error("has been changed");
  if (!std::ranges::all_of(m.verb, is_letter) || !are_arguments(m.verb, m.arguments) || m.shards > m.units ||
      m.units > most_units)
    throw std::runtime_error("says what no plan does");
}

}  // namespace

Manifest read_manifest(const std::filesystem::path& folder) {
  const auto file = shards_folder(folder) / "manifest.json";
  if (std::filesystem::is_symlink(shards_folder(folder)))
    throw SceneError(
        fmt::format("{}: is a link; shards lie in a folder of their own", shards_folder(folder).string()));
  if (!std::filesystem::exists(file))
    throw SceneError(fmt::format("{}: contains no plan; `freeplay VERB STUDY --plan N -o {}` divides a study",
                                 file.string(), folder.string()));
  const auto no_manifest = [&](const char* why) {
    return SceneError(fmt::format("{}: is not a manifest of this version ({}); plan into another folder",
                                  file.string(), why));
  };
  const JsonFile read(file);
  try {
    auto m = record_of<Manifest>(read.document());
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
    auto other = m;
    other.verb = study.verb;
    other.arguments = study.arguments;
    return command_for(other, {"--plan", std::to_string(m.shards), "-o", folder.string() + "-2"});
  };
  if (const auto here = program_identity(); m.program != here)
    throw SceneError(fmt::format(
        "{}: was planned by another program or for other processors ({}); run the program of the plan, or "
        "plan anew: {}",
        shards_folder(folder).string(), difference(m.program, here), again()));
  if (m.verb != study.verb || m.arguments != study.arguments || m.subject != study.subject)
    throw SceneError(
        fmt::format("{}: the study has changed since it was planned ({} {}); undo the change, or plan "
                    "again: {}",
                    shards_folder(folder).string(), m.verb, shell_words(m.arguments), again()));
}

std::vector<Unit> units_of(const Manifest& m, const std::filesystem::path& folder, std::size_t shard) {
  const auto at = [&](std::size_t k) { return k * m.units / m.shards; };
  const auto begin = at(shard - 1), end = at(shard);
  const auto slip_forced = [&] {
    return SceneError(
        fmt::format("{}: is incomplete; plan again into another folder", units_file(folder).string()));
  };
  std::error_code none;
  if (std::filesystem::file_size(units_file(folder), none) != m.units * line || none) throw slip_forced();
  std::ifstream in(units_file(folder), std::ios::binary);
  std::string text((end - begin) * line, '\0');
  in.seekg(static_cast<std::streamoff>(begin * line));
  if (!in.read(text.data(), static_cast<std::streamsize>(text.size()))) throw slip_forced();
  std::vector<Unit> units;
  for (std::size_t i = 0; i < end - begin; ++i) {
    const char* const number = text.data() + i * line + key_letters + 1;
    Unit unit{text.substr(i * line, key_letters), 0};
    if (std::from_chars(number, number + number_letters, unit.number).ptr != number + number_letters)
      throw slip_forced();
    units.push_back(unit);
  }
  return units;
}

std::string command_for(const Manifest& m, const std::vector<std::string>& more) {
  return fmt::format("freeplay {} {} {}", m.verb, shell_words(m.arguments), shell_words(more));
}

std::optional<Seal> read_seal(const std::filesystem::path& folder, std::size_t shard) {
  const auto file = shards_folder(folder) / fmt::format("{}.json", shard);
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    return record_of<Seal>(JsonFile(file).document());
  } catch (const std::exception&) {
    return Seal{};  // an invalid seal, which fault_of() reports
  }
}

std::string fault_of(const Seal& seal, const Manifest& m, const std::filesystem::path& folder, bool deep) {
  if (seal.plan.empty() || seal.file.find('/') != seal.file.npos || !seal.file.ends_with(".db"))
    return "its seal is damaged";
  if (seal.plan != m.plan) return "it is of another plan, or another program's";
  const auto file = shards_folder(folder) / seal.file;
  std::error_code none;
  if (std::filesystem::is_symlink(file, none) || std::filesystem::file_size(file, none) != seal.bytes || none)
    return "its file is incomplete or missing";
  if (deep && file_checksum(file) != seal.checksum) return "its file is damaged";
  return {};
}

}  // namespace freeplay
