// An HDF5 file that is written: groups, attributes, and columns block by block. Every call is checked.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "plots/export/hdf5_library.hpp"

namespace freeplay::hdf5 {

/// What HDF5 has opened, closed with the object.
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
  /// Whether closing it succeeded.
  bool close() { return close_(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_;
  Close close_;
};

/// Rows of a dataset are written, compressed and read by blocks.
struct Block {
  std::size_t rows, length;  ///< of the dataset, of a block
};

class File {
 public:
  /// Grows beside its place as NAME.partial. Throws OutputError, as all here.
  explicit File(const std::filesystem::path& path);
  /// What is not committed is removed.
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  /// Puts it in its place.
  void commit();

  hid_t root() const { return file_.id(); }
  /// `name`: not empty, no "/", not "." (HDF5 takes these for paths), not there yet; else SceneError.
  Handle group(hid_t parent, const std::string& name) const;
  void set(hid_t at, const std::string& name, const std::string& text) const;
  void set(hid_t at, const std::string& name, double number) const;
  void set(hid_t at, const std::string& name, std::int64_t number) const;
  void set(hid_t at, const std::string& name, bool flag) const;
  void set(hid_t at, const std::string& name, const std::vector<double>& numbers) const;
  void set(hid_t at, const std::string& name, const std::vector<std::string>& texts) const;
  /// Numbers.
  Handle numbers(hid_t group, const std::string& name, Block block) const;
  /// Texts of `width` bytes at most, filled up with zeros.
  Handle texts(hid_t group, const std::string& name, Block block, std::size_t width) const;
  /// Rows from `from` on; of texts their bytes one after another.
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
