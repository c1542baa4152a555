// A result folder as one HDF5 file. Each table is read twice: first to check it and to find the
// number of rows and the lengths of the texts, then to write it. A damaged table is thus an error
// before anything is written.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "io/files/build_identity.hpp"
#include "io/files/input_file.hpp"
#include "io/scene/points_file.hpp"
#include "mechanism/error.hpp"
#include "plots/export/export.hpp"
#include "plots/export/hdf5_file.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::hdf5 {
namespace {

using Json = nlohmann::json;

constexpr std::size_t most_in_array = 4096;

std::string dumped(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

bool is_text(const Json& value) {
  // A text with a zero byte would be truncated there.
  return value.is_string() && value.get_ref<const std::string&>().find('\0') == std::string::npos;
}

/// Whether a double represents the value exactly. Other integers are written as text.
bool is_double(const Json& value) {
  if (value.is_number_float()) return true;
  constexpr double limit = 9007199254740992.0;  // 2^53
  return value.is_number() && std::abs(value.get<double>()) <= limit;
}

bool is_whole(const Json& value) {
  return value.is_number_integer() &&
         (!value.is_number_unsigned() ||
          value.get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()));
}

void set(const File& file, hid_t at, const std::string& key, const Json& value) {
  const bool list = value.is_array() && !value.empty() && value.size() <= most_in_array;
  if (is_text(value))
    file.set(at, key, value.get<std::string>());
  else if (value.is_boolean())
    file.set(at, key, value.get<bool>());
  else if (is_whole(value))
    file.set(at, key, value.get<std::int64_t>());
  else if (value.is_number())
    file.set(at, key, value.get<double>());
  else if (list && std::ranges::all_of(value, is_double))
    file.set(at, key, value.get<std::vector<double>>());
  else if (list && std::ranges::all_of(value, is_text))
    file.set(at, key, value.get<std::vector<std::string>>());
  else
    file.set(at, key, dumped(value));
}

/// Writes the members of an object as attributes of the group `at`. Objects in it become subgroups,
/// lists of numbers or of texts become arrays, and other values become JSON text.
void mirror(const File& file, hid_t at, const Json& object) {
  for (const auto& [key, value] : object.items())
    if (value.is_object())
      mirror(file, file.group(at, key).id(), value);
    else
      set(file, at, key, value);
}

/// Unit of a column, otherwise by the suffix of a name in result files: "m/s" for greatest_m_per_s; "" if it
/// has none.
std::string unit_of(const std::string& name) {
  constexpr std::string_view error = "_standard_error";
  if (name.ends_with(error)) return unit_of(name.substr(0, name.size() - error.size()));
  if (const auto unit = plots::unit_of_column(name); !unit.empty()) return std::string(unit);
  return plots::number_of_run(name.substr(name.rfind('.') + 1)).unit;
}

/// Writes the statistics of the contacts from run.json, one dataset per field: NaN if a contact has
/// no such value; standard errors as FIELD_standard_error. A run without contacts writes nothing.
/// Returns the number of contacts.
std::size_t statistics(const File& file, hid_t at, const Json& run) {
  const auto contacts = run.find("contacts");
  if (contacts == run.end() || !contacts->is_object() || contacts->empty()) return 0;
  const auto count = contacts->size();
  std::size_t width = 1, row = 0;
  std::map<std::string, std::vector<double>> fields;
  const auto take = [&](const std::string& name, const Json& value) {
    if (!value.is_number()) return;
    fields.try_emplace(name, count, std::nan("")).first->second[row] = value.get<double>();
  };
  for (const auto& [name, facts] : contacts->items()) {
    width = std::max(width, name.size());
    if (facts.is_object())
      for (const auto& [key, value] : facts.items()) {
        take(key, value);
        if (key == "standard_errors" && value.is_object())
          for (const auto& [of, error] : value.items()) take(of + "_standard_error", error);
      }
    ++row;
  }
  std::vector<char> names(count * width, 0);
  row = 0;
  for (const auto& [name, facts] : contacts->items())
    std::ranges::copy(name, names.begin() + static_cast<std::ptrdiff_t>(width * row++));
  const auto group = file.group(at, "statistics");
  const Block block{count, count};
  file.write(file.texts(group.id(), "contact", block, width), 0, count, width, names);
  for (const auto& [name, values] : fields) {
    const auto column = file.numbers(group.id(), name, block);
    file.write(column, 0, values);
    file.set(column.id(), "units", unit_of(name));
  }
  file.set(group.id(), "rows", static_cast<std::int64_t>(count));
  return count;
}

}  // namespace
}  // namespace freeplay::hdf5

namespace freeplay {
namespace {

using Path = std::filesystem::path;
using plots::Rows;

/// Properties of a table from its first reading.
struct Found {
  Path file;
  std::vector<std::string> names;
  std::vector<std::size_t> widths;  ///< bytes of the texts; 0: column of numbers
  std::size_t rows = 0;
};

/// A folder with the results of one run or one command.
struct Source {
  std::string group;  ///< "" for the folder itself
  Path folder;
  std::vector<Found> tables;
  std::vector<Path> documents;
};

/// Columns of names, even if the names look like numbers.
bool holds_names(std::string_view column) {
  return column == "joint" || column == "kind" || column == "channel" || column == "name";
}

void ask(const StopToken& stop) {
  if (stop()) throw Interrupted();
}

/// The first field of a column determines the type of the others. An empty field of a column of
/// numbers is NaN.
Found first_reading(const Path& file, const StopToken& stop) {
  Rows in(file);
  Found found{file, in.names(), std::vector<std::size_t>(in.names().size(), 0), 0};
  if (std::set(found.names.begin(), found.names.end()).size() != found.names.size())
    throw SceneError(file.string() + ":1: has two columns of the same name");
  enum class Kind { open, number, text };
  std::vector<Kind> kinds;
  for (const auto& name : found.names) kinds.push_back(holds_names(name) ? Kind::text : Kind::open);
  while (in.next()) {
    if (found.rows++ % 4096 == 0) ask(stop);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (kinds[i] == Kind::number) {
        in.maybe_number(i);
        continue;
      }
      const auto& text = in.maybe_label(i);
      if (kinds[i] == Kind::open && !text.empty()) kinds[i] = number_in(text) ? Kind::number : Kind::text;
      if (kinds[i] == Kind::text) found.widths[i] = std::max(found.widths[i], text.size());
    }
  }
  for (std::size_t i = 0; i < kinds.size(); ++i)
    if (kinds[i] == Kind::text) found.widths[i] = std::max<std::size_t>(found.widths[i], 1);
  return found;
}

/// Reads only regular files of the folder; targets of links are not results of it.
Source read_first(const std::string& group, const Path& folder, const StopToken& stop) {
  Source source{group, folder, {}, {}};
  std::vector<Path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::error_code error;
    if (std::filesystem::is_regular_file(entry.symlink_status(error)) &&
        !entry.path().filename().string().starts_with('.'))
      files.push_back(entry.path());
  }
  std::ranges::sort(files);
  for (const auto& file : files) {
    if (file.extension() == ".json") source.documents.push_back(file);
    if (file.extension() == ".csv") source.tables.push_back(first_reading(file, stop));
  }
  return source;
}

std::vector<Source> sources_in(const Path& folder, const StopToken& stop) {
  std::vector<Source> list{read_first("", folder, stop)};
  if (std::filesystem::exists(folder / "comparison.json"))
    for (const char* run : {"penalty", "nonsmooth", "ideal"}) {
      std::error_code error;
      if (std::filesystem::is_directory(std::filesystem::symlink_status(folder / run, error)))
        list.push_back(read_first(run, folder / run, stop));
    }
  for (const auto& source : list)
    if (!source.tables.empty()) return list;
  throw SceneError(
      folder.string() +
      ": contains no result tables to export; give a folder made by freeplay run, compare or another verb");
}

/// Rows per block such that at most 32 MiB of 64-bit numbers are in memory, for any number of
/// columns.
std::size_t block_length(std::size_t columns) {
  return std::clamp<std::size_t>((std::size_t{4} << 20) / std::max<std::size_t>(columns, 1), 64, 16384);
}

[[noreturn]] void changed(const Path& file) {
  throw SceneError(file.string() +
                   ": changed while it was read; export it when no other process writes "
                   "there");
}

/// Writes the columns of one table block by block.
class TableWriter {
 public:
  TableWriter(const hdf5::File& file, hid_t parent, const Found& found, const StopToken& stop)
      : file_(file),
        found_(found),
        stop_(stop),
        length_(block_length(found.names.size())),
        group_(file.group(parent, found.file.stem().string())) {
    const hdf5::Block block{found.rows, length_};
    for (std::size_t i = 0; i < found.names.size(); ++i) {
      const bool number = found.widths[i] == 0;
      columns_.push_back(number ? file.numbers(group_.id(), found.names[i], block)
                                : file.texts(group_.id(), found.names[i], block, found.widths[i]));
      if (number) file.set(columns_.back().id(), "units", hdf5::unit_of(found.names[i]));
    }
    numbers_.resize(columns_.size());
    bytes_.resize(columns_.size());
    file.set(group_.id(), "source", found.file.filename().string());
    file.set(group_.id(), "rows", static_cast<std::int64_t>(found.rows));
    file.set(group_.id(), "columns", found.names);
  }
  const hdf5::Handle& group() const { return group_; }

  void write() {
    Rows in(found_.file);
    if (in.names() != found_.names) changed(found_.file);
    std::size_t row = 0;
    for (; in.next(); ++row) {
      if (row > 0 && row % length_ == 0) flush(row);
      for (std::size_t i = 0; i < columns_.size(); ++i) take(in, i);
    }
    if (row != found_.rows) changed(found_.file);
    flush(row);
  }

 private:
  void take(const Rows& in, std::size_t i) {
    const auto width = found_.widths[i];
    if (width == 0) {
      numbers_[i].push_back(in.maybe_number(i));
      return;
    }
    const auto& text = in.maybe_label(i);
    if (text.size() > width) changed(found_.file);
    bytes_[i].insert(bytes_[i].end(), text.begin(), text.end());
    bytes_[i].resize(bytes_[i].size() + width - text.size(), 0);
  }
  /// Writes the buffered rows up to `end`.
  void flush(std::size_t end) {
    ask(stop_);
    if (end > found_.rows) changed(found_.file);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (const auto width = found_.widths[i]; width > 0)
        file_.write(columns_[i], written_, end - written_, width, bytes_[i]);
      else
        file_.write(columns_[i], written_, numbers_[i]);
      numbers_[i].clear();
      bytes_[i].clear();
    }
    written_ = end;
  }

  const hdf5::File& file_;
  const Found& found_;
  StopToken stop_;
  std::size_t length_, written_ = 0;
  hdf5::Handle group_;
  std::vector<hdf5::Handle> columns_;
  std::vector<std::vector<double>> numbers_;
  std::vector<std::vector<char>> bytes_;
};

/// Each instrument has its own unit: writes arrays of names and units beside the samples.
void tell_channels(const hdf5::File& file, hid_t signals, const Path& folder) {
  std::vector<std::string> channels, units;
  const plots::RunColumns run(folder);
  for (const auto& column : run.all())
    if (!column.channel.empty()) {
      channels.push_back(column.channel);
      units.push_back(column.unit);
    }
  if (channels.empty()) return;
  file.set(signals, "channels", channels);
  file.set(signals, "channel_units", units);
}

void write(const hdf5::File& file, hid_t at, const Source& source, const StopToken& stop, Exported& done) {
  for (const auto& path : source.documents) {
    const JsonFile json(path);
    const auto name = path.filename().string();
    file.set(at, name, read_file(path, most_of_a_result));
    if (name != "run.json" || !json.document().is_object()) continue;
    hdf5::mirror(file, file.group(at, "run").id(), json.document());
    if (const auto contacts = hdf5::statistics(file, at, json.document())) {
      ++done.tables;
      done.rows += contacts;
    }
  }
  const bool run = std::filesystem::exists(source.folder / "run.json");
  for (const auto& table : source.tables) {
    TableWriter writer(file, at, table, stop);
    writer.write();
    if (run && table.file.filename() == "signals.csv")
      tell_channels(file, writer.group().id(), source.folder);
    ++done.tables;
    done.rows += table.rows;
  }
}

}  // namespace

void require_hdf5() { hdf5::library(); }

Exported export_hdf5(const Path& folder, const Path& path, StopToken stop) {
  require_hdf5();
  const auto sources = sources_in(folder, stop);
  Exported done;
  hdf5::File file(path);
  file.set(file.root(), "exported_by", "freeplay " + version_text());
  for (const auto& source : sources)
    if (source.group.empty())
      write(file, file.root(), source, stop, done);
    else
      write(file, file.group(file.root(), source.group).id(), source, stop, done);
  file.commit();
  return done;
}

}  // namespace freeplay
