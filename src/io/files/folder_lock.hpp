// Exclusive or shared right to write into a folder. It is an operating-system lock on the file
// .freeplay.lock in the folder, so it ends with the process, even if that is killed; a file that
// remains does not block others. The file contains a description of each holder, for messages. The
// last process that ends normally removes it.
//
//     byte 0    write lock: one exclusive process; read lock: processes that share the folder
//     byte k    locked by the process in slot k, whose description is record k of the file
//
// A FolderLock owns the descriptor of the file and releases the lock on destruction.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace freeplay {

/// Holds the right to write into one folder during its lifetime.
class FolderLock {
 public:
  /// `alone`: no other process may write into the folder; `together`: others may, if all share it.
  enum class Use { alone, together };

  /// Acquires the lock of an existing folder. Throws OutputError, which names the holders, if
  /// another process holds the folder and either process requires it alone. `verb`: activity of
  /// this process, for messages of other processes.
  FolderLock(const std::filesystem::path& folder, std::string_view verb, Use use = Use::alone);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  /// Slot of this process, from 1; unique among living processes.
  int slot() const { return slot_; }
  /// Whether a living process, possibly this one, has this slot.
  bool taken(int slot) const;
  /// The other processes that write into the folder, as one line; "" if there are none.
  std::string others() const;

 private:
  /// Tries to open and lock the file once; false if others hold it.
  bool acquire();
  [[noreturn]] void refuse(const std::string& why) const;

  std::filesystem::path folder_, file_;
  Use use_;
  int descriptor_ = -1;
  int slot_ = 0;
};

}  // namespace freeplay
