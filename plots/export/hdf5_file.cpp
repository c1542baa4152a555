#include "plots/export/hdf5_file.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "io/files/escaping.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"

namespace freeplay::hdf5 {
namespace {

[[noreturn]] void missing(const char* why) {
  throw SceneError(
      fmt::format("--hdf5: the HDF5 library {} cannot be used: {}; Debian: apt install libhdf5-103-1",
                  FREEPLAY_HDF5, why ? why : "no reason given"));
}

void* symbol(void* handle, const char* name) {
  void* found = dlsym(handle, name);
  if (!found) missing(dlerror());
  return found;
}

Library opened() {
  // The file name contains the version of the binary interface that matches the header.
  void* handle = dlopen(FREEPLAY_HDF5, RTLD_NOW | RTLD_LOCAL);
  if (!handle) missing(dlerror());
  Library l;
#define FREEPLAY_FIND(name) l.name = reinterpret_cast<decltype(l.name)>(symbol(handle, #name));
  FREEPLAY_HDF5_FUNCTIONS(FREEPLAY_FIND)
#undef FREEPLAY_FIND
  // At exit HDF5 would retry writes that failed on a full disk, and crash. All files are closed by
  // then.
  l.H5dont_atexit();
  if (l.H5open() < 0) missing("it does not start");
#define FREEPLAY_FIND(name) l.name = *static_cast<hid_t*>(symbol(handle, #name));
  FREEPLAY_HDF5_NUMBERS(FREEPLAY_FIND)
#undef FREEPLAY_FIND
  l.H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are reported by this program
  return l;
}

}  // namespace

const Library& library() {
  static const Library l = opened();
  return l;
}

namespace {

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

/// Creates the file. HDF5 opens files itself and follows links; therefore the path must not exist
/// and no folder of it may be a link.
hid_t created(const Library& h, const std::filesystem::path& path, const std::filesystem::path& partial) {
  require_own(path);
  remove_file(partial);
  const Handle access(h.H5Pcreate(h.H5P_CLS_FILE_ACCESS_ID_g), h.H5Pclose),
      made(h.H5Pcreate(h.H5P_CLS_FILE_CREATE_ID_g), h.H5Pclose);
  // Readable by HDF5 1.8 (2008) and later, which support attributes above 64 KiB.
  if (h.H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_V110) < 0) return -1;
  // identical results give identical bytes
  if (h.H5Pset_obj_track_times(made.id(), false) < 0) return -1;
  errno = 0;
  return h.H5Fcreate(partial.c_str(), H5F_ACC_EXCL, made.id(), access.id());
}

}  // namespace

File::File(const std::filesystem::path& path)
    : path_(folder_of(path) / path.filename()),
      partial_(folder_of(path) / (path.filename().string() + ".partial")),
      file_(checked(created(h_, path_, partial_), h_.H5Fclose, "be made")) {}

File::~File() {
  if (done_) return;
  if (file_.id() >= 0) file_.close();
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
}

void File::commit() {
  errno = 0;
  if (!file_.close()) check(-1, "be completed");
  std::error_code error;
  std::filesystem::rename(partial_, path_, error);
  if (error)
    throw OutputError(fmt::format("{}: cannot be put in its place: {}", path_.string(), error.message()));
  done_ = true;
}

Handle File::checked(hid_t id, Handle::Close close, const std::string& what) const {
  check(id < 0 ? -1 : 0, what);
  return {id, close};
}

void File::check(herr_t status, const std::string& what) const {
  if (status >= 0) return;
  throw OutputError(fmt::format("{}: cannot {}: {}", path_.string(), what,
                                errno != 0 ? std::strerror(errno) : "HDF5 error"));
}

void File::require_name(const std::string& name) const {
  if (name.empty() || name == "." || name.find('/') != name.npos || name.find('\0') != name.npos)
    throw SceneError(
        fmt::format("\"{}\": is not a valid name in HDF5: it must not be empty or \".\", or "
                    "contain \"/\"",
                    visible_brief(name, 60)));
}

Handle File::group(hid_t parent, const std::string& name) const {
  require_name(name);
  const auto what = "hold the group " + visible_brief(name, 60);
  const auto made = checked(h_.H5Pcreate(h_.H5P_CLS_GROUP_CREATE_ID_g), h_.H5Pclose, what);
  check(h_.H5Pset_obj_track_times(made.id(), false), what);
  return checked(h_.H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, made.id(), H5P_DEFAULT), h_.H5Gclose, what);
}

Handle File::space(std::size_t length) const {
  const hsize_t size = length;
  return checked(h_.H5Screate_simple(1, &size, nullptr), h_.H5Sclose, "hold so many rows");
}

/// Type of UTF-8 texts; width 0: variable length.
Handle File::text_type(std::size_t width) const {
  auto type = checked(h_.H5Tcopy(h_.H5T_C_S1_g), h_.H5Tclose, "hold texts");
  check(h_.H5Tset_size(type.id(), width == 0 ? H5T_VARIABLE : width), "hold texts");
  check(h_.H5Tset_cset(type.id(), H5T_CSET_UTF8), "hold texts");
  if (width > 0) check(h_.H5Tset_strpad(type.id(), H5T_STR_NULLPAD), "hold texts");
  return type;
}

void File::attribute(hid_t at, const std::string& name, hid_t type, hid_t in_file, hid_t space,
                     const void* value) const {
  if (name.empty() || name.find('\0') != name.npos)
    throw SceneError(fmt::format("\"{}\": is not a valid name of an attribute", visible_brief(name, 60)));
  const auto what = "hold the attribute " + visible_brief(name, 60);
  const auto made =
      checked(h_.H5Acreate2(at, name.c_str(), in_file, space, H5P_DEFAULT, H5P_DEFAULT), h_.H5Aclose, what);
  check(h_.H5Awrite(made.id(), type, value), what);
}

void File::set(hid_t at, const std::string& name, const std::string& text) const {
  const auto type = text_type(0), one = checked(h_.H5Screate(H5S_SCALAR), h_.H5Sclose, "hold texts");
  const char* value = text.c_str();
  attribute(at, name, type.id(), type.id(), one.id(), &value);
}

void File::set(hid_t at, const std::string& name, double number) const {
  const auto one = checked(h_.H5Screate(H5S_SCALAR), h_.H5Sclose, "hold numbers");
  attribute(at, name, h_.H5T_NATIVE_DOUBLE_g, h_.H5T_IEEE_F64LE_g, one.id(), &number);
}

void File::set(hid_t at, const std::string& name, std::int64_t number) const {
  const auto one = checked(h_.H5Screate(H5S_SCALAR), h_.H5Sclose, "hold numbers");
  attribute(at, name, h_.H5T_NATIVE_INT64_g, h_.H5T_STD_I64LE_g, one.id(), &number);
}

/// Sets a flag in the form that h5py uses: an enumeration of FALSE and TRUE.
void File::set(hid_t at, const std::string& name, bool flag) const {
  const auto type = checked(h_.H5Tenum_create(h_.H5T_NATIVE_INT8_g), h_.H5Tclose, "hold flags"),
             one = checked(h_.H5Screate(H5S_SCALAR), h_.H5Sclose, "hold flags");
  const std::int8_t no = 0, yes = 1, value = flag;
  check(h_.H5Tenum_insert(type.id(), "FALSE", &no), "hold flags");
  check(h_.H5Tenum_insert(type.id(), "TRUE", &yes), "hold flags");
  attribute(at, name, type.id(), type.id(), one.id(), &value);
}

void File::set(hid_t at, const std::string& name, const std::vector<double>& numbers) const {
  attribute(at, name, h_.H5T_NATIVE_DOUBLE_g, h_.H5T_IEEE_F64LE_g, space(numbers.size()).id(),
            numbers.data());
}

void File::set(hid_t at, const std::string& name, const std::vector<std::string>& texts) const {
  std::vector<const char*> values;
  for (const auto& text : texts) values.push_back(text.c_str());
  const auto type = text_type(0);
  attribute(at, name, type.id(), type.id(), space(values.size()).id(), values.data());
}

Handle File::dataset(hid_t group, const std::string& name, Block block, hid_t type) const {
  require_name(name);
  const auto what = "hold the column " + visible_brief(name, 60);
  const auto made = checked(h_.H5Pcreate(h_.H5P_CLS_DATASET_CREATE_ID_g), h_.H5Pclose, what),
             access = checked(h_.H5Pcreate(h_.H5P_CLS_DATASET_ACCESS_ID_g), h_.H5Pclose, what);
  check(h_.H5Pset_obj_track_times(made.id(), false), what);
  if (block.rows > 0) {
    const hsize_t chunk = std::min(block.rows, block.length);
    check(h_.H5Pset_chunk(made.id(), 1, &chunk), what);
    if (h_.H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0) {
      check(h_.H5Pset_shuffle(made.id()), what);
      check(h_.H5Pset_deflate(made.id(), 1), what);
    }
    // each block is written completely and once
    check(h_.H5Pset_chunk_cache(access.id(), 0, 0, 1), what);
  }
  return checked(
      h_.H5Dcreate2(group, name.c_str(), type, space(block.rows).id(), H5P_DEFAULT, made.id(), access.id()),
      h_.H5Dclose, what);
}

Handle File::numbers(hid_t group, const std::string& name, Block block) const {
  return dataset(group, name, block, h_.H5T_IEEE_F64LE_g);
}

Handle File::texts(hid_t group, const std::string& name, Block block, std::size_t width) const {
  return dataset(group, name, block, text_type(width).id());
}

void File::write_rows(const Handle& column, std::size_t from, std::size_t rows, hid_t type,
                      const void* data) const {
  if (rows == 0) return;
  const auto memory = space(rows);
  const hsize_t start = from, count = rows;
  const auto place = checked(h_.H5Dget_space(column.id()), h_.H5Sclose, "be written");
  check(h_.H5Sselect_hyperslab(place.id(), H5S_SELECT_SET, &start, nullptr, &count, nullptr), "be written");
  errno = 0;
  check(h_.H5Dwrite(column.id(), type, memory.id(), place.id(), H5P_DEFAULT, data), "be written");
}

void File::write(const Handle& column, std::size_t from, const std::vector<double>& rows) const {
  write_rows(column, from, rows.size(), h_.H5T_NATIVE_DOUBLE_g, rows.data());
}

void File::write(const Handle& column, std::size_t from, std::size_t rows, std::size_t width,
                 const std::vector<char>& bytes) const {
  write_rows(column, from, rows, text_type(width).id(), bytes.data());
}

}  // namespace freeplay::hdf5
