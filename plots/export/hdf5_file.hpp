// Writes an HDF5 file: groups, attributes, and columns block by block. The result of every call is
// checked.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

// The functions of HDF5 that are used. The library is loaded on demand instead of linked: loading
// it with its dependencies takes 6 ms, more than the whole program, and the rest of the program
// must run on computers without it.

// These macros would call the library before it is loaded. library() loads it first.
#undef H5CHECK
#undef H5OPEN
#define H5CHECK
#define H5OPEN

#define FREEPLAY_HDF5_FUNCTIONS(f)                                                                        \
  f(H5dont_atexit) f(H5open) f(H5Eset_auto2) f(H5Pcreate) f(H5Pclose) f(H5Pset_libver_bounds)             \
      f(H5Pset_chunk) f(H5Pset_shuffle) f(H5Pset_deflate) f(H5Pset_chunk_cache) f(H5Pset_obj_track_times) \
          f(H5Zfilter_avail) f(H5Fcreate) f(H5Fclose) f(H5Gcreate2) f(H5Gclose) f(H5Screate)              \
              f(H5Screate_simple) f(H5Sselect_hyperslab) f(H5Sclose) f(H5Tcopy) f(H5Tset_size)            \
                  f(H5Tset_cset) f(H5Tset_strpad) f(H5Tenum_create) f(H5Tenum_insert) f(H5Tclose)         \
                      f(H5Dcreate2) f(H5Dwrite) f(H5Dclose) f(H5Dget_space) f(H5Acreate2) f(H5Awrite)     \
                          f(H5Aclose)
#define FREEPLAY_HDF5_NUMBERS(f)                                                                            \
  f(H5T_NATIVE_DOUBLE_g) f(H5T_IEEE_F64LE_g) f(H5T_NATIVE_INT64_g) f(H5T_STD_I64LE_g) f(H5T_NATIVE_INT8_g)  \
      f(H5T_C_S1_g) f(H5P_CLS_FILE_ACCESS_ID_g) f(H5P_CLS_DATASET_CREATE_ID_g) f(H5P_CLS_GROUP_CREATE_ID_g) \
          f(H5P_CLS_FILE_CREATE_ID_g) f(H5P_CLS_DATASET_ACCESS_ID_g)

namespace freeplay::hdf5 {

struct Library {
// A member name must not be in parentheses.
// NOLINTNEXTLINE(bugprone-macro-parentheses)
#define FREEPLAY_MEMBER(name) decltype(&::name) name = nullptr;
  FREEPLAY_HDF5_FUNCTIONS(FREEPLAY_MEMBER)
#undef FREEPLAY_MEMBER
#define FREEPLAY_MEMBER(name) hid_t name = -1;
  FREEPLAY_HDF5_NUMBERS(FREEPLAY_MEMBER)
#undef FREEPLAY_MEMBER
};

/// Loads the library at the first call. Throws SceneError, which names the package to install.
const Library& library();

/// Owns an HDF5 identifier and closes it in the destructor.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close close) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  hid_t id() const { return id_; }
  /// Closes the identifier and returns whether this succeeded.
  bool close() { return close_(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_;
  Close close_;
};

/// Rows of a dataset are written, compressed and read in blocks.
struct Block {
  std::size_t rows, length;  ///< rows of the dataset, rows of a block
};

class File {
 public:
  /// Creates the file as NAME.partial in the same folder. All functions of this class throw
  /// OutputError.
  explicit File(const std::filesystem::path& path);
  /// Removes the file unless it was committed.
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  /// Renames the complete file to its final name.
  void commit();

  hid_t root() const { return file_.id(); }
  /// Creates a group. Throws SceneError if `name` is empty, contains "/" or is "." (paths in HDF5),
  /// or exists already.
  Handle group(hid_t parent, const std::string& name) const;
  void set(hid_t at, const std::string& name, const std::string& text) const;
  void set(hid_t at, const std::string& name, double number) const;
  void set(hid_t at, const std::string& name, std::int64_t number) const;
  void set(hid_t at, const std::string& name, bool flag) const;
  void set(hid_t at, const std::string& name, const std::vector<double>& numbers) const;
  void set(hid_t at, const std::string& name, const std::vector<std::string>& texts) const;
  /// Creates a column of numbers.
  Handle numbers(hid_t group, const std::string& name, Block block) const;
  /// Creates a column of texts of at most `width` bytes, padded with zeros.
  Handle texts(hid_t group, const std::string& name, Block block, std::size_t width) const;
  /// Writes rows from index `from` on; texts as their concatenated bytes.
  void write(const Handle& column, std::size_t from, const std::vector<double>& rows) const;
  void write(const Handle& column, std::size_t from, std::size_t rows, std::size_t width,
             const std::vector<char>& bytes) const;

 private:
  Handle dataset(hid_t group, const std::string& name, Block block, hid_t type) const;
  void attribute(hid_t at, const std::string& name, hid_t type, hid_t in_file, hid_t space,
                 const void* value) const;
  Handle space(std::size_t length) const;
  Handle text_type(std::size_t width) const;
  void write_rows(const Handle& column, std::size_t from, std::size_t rows, hid_t type,
                  const void* data) const;
  Handle checked(hid_t id, Handle::Close close, const std::string& what) const;
  void check(herr_t status, const std::string& what) const;
  void require_name(const std::string& name) const;

  const Library& h_ = library();
  std::filesystem::path path_, partial_;
  Handle file_;
  bool done_ = false;
};

}  // namespace freeplay::hdf5
