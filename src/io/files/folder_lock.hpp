// The right to write into a folder. It is a lock of the operating system on the folder's file .freeplay.lock, and ends
// with the process that has it, however that ends: what a killed process leaves of the file is in nobody's way. Who has
// the right stands in the file, for messages. A process that ends in order removes it.
//
//     byte 0    locked for writing by one who writes alone, for reading by those who write together
//     byte k    locked by the process with seat k, whose description is the file's k-th record
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace freeplay {

class FolderLock {
 public:
  enum class Use { alone, together };

  /// The folder must be there. Throws OutputError when others write into it and either of them or this one wants to be
  /// alone; it names them. `verb`: what this process does, for the others' messages.
  FolderLock(const std::filesystem::path& folder, std::string_view verb, Use use = Use::alone);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  /// From 1; no two that live have the same at a time.
  int seat() const { return seat_; }
  /// Whether a living process has this seat, this one included.
  bool taken(int seat) const;
  /// Those who write into the folder beside this one, in one line; "" when there is none.
  std::string others() const;

 private:
  /// Opens and locks once; false where others have the right.
  bool acquire();
  [[noreturn]] void refuse(const std::string& why) const;

  std::filesystem::path folder_, file_;
  Use use_;
  int descriptor_ = -1;
  int seat_ = 0;
};

}  // namespace freeplay
