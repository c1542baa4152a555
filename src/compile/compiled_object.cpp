#include "compile/compiled_object.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "io/files/access.hpp"
#include "io/files/child.hpp"
#include "io/files/digest.hpp"
#include "io/files/escaping.hpp"

namespace freeplay {
namespace {

namespace fs = std::filesystem;

constexpr off_t largest_object = 64 << 20;  // bytes
/// Above this number of files the cache is emptied.
constexpr int most_objects = 1000;

/// -O1: -O2 takes longer and gains little on straight code; of its parts, one leaves the wide registers
/// of lanes clean.
/// AVX saves moves and has registers for lanes; each of its operations is bitwise identical to that of the
/// base instruction set, unlike fused multiply-add.
const std::vector<std::string>& compiler() {
  static const std::vector<std::string> command = [] {
    std::vector<std::string> c{"cc",
                               "-x",
                               "c",
                               "-std=c99",
                               "-O1",
                               "-fexpensive-optimizations",
                               "-fstrict-aliasing",
                               "-ffp-contract=off",
                               "-fno-math-errno",
                               "-fPIC",
                               "-w",
                               "-shared"};
#if defined(__x86_64__)
    c.emplace_back(__builtin_cpu_supports("avx512f") ? "-mavx512f"
                   : __builtin_cpu_supports("avx2")  ? "-mavx2"
                   : __builtin_cpu_supports("avx")   ? "-mavx"
                                                     : "-msse2");
#endif
    return c;
  }();
  return command;
}

/// A reason why there is no object.
struct Refused {
  std::string reason;
};

/// The compiler's name, version and target; asked once. Like every compilation it works in a private
/// folder, because PATH may name the working folder.
const std::string& compiler_identity(const fs::path& folder) {
  static const std::string identity = [&] {
    const auto end = run_child({.command = {"cc", "-v"}, .folder = folder, .seconds = 10});
    return end.status == 0 ? end.errors : std::string();
  }();
  return identity;
}

Refused refused(const fs::path& place, const char* why) {
  return {fmt::format("{}: {}", visible_brief(place.string()), why)};
}

/// The user's cache folder, which may be reached by links of the user's own.
fs::path user_cache() {
  if (const char* named = std::getenv("XDG_CACHE_HOME"); named && *named == '/') return named;
  if (const char* home = std::getenv("HOME"); home && *home == '/') return fs::path(home) / ".cache";
  throw Refused{"there is no cache folder: neither XDG_CACHE_HOME nor HOME is an absolute path"};
}

/// Opens the private folder of objects, and makes it if it does not exist.
Descriptor private_folder(const fs::path& folder) {
  std::error_code ignored;
  fs::create_directories(folder.parent_path(), ignored);
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) throw refused(folder, std::strerror(errno));
  Descriptor open_folder(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!open_folder)
    throw refused(folder, errno == ELOOP || errno == ENOTDIR ? "is not a folder, or a symbolic link"
                                                             : std::strerror(errno));
  struct stat facts {};
  if (fstat(open_folder.number(), &facts) != 0) throw refused(folder, std::strerror(errno));
  if (facts.st_uid != geteuid()) throw refused(folder, "belongs to another user");
  if ((facts.st_mode & 077) != 0) throw refused(folder, "is open to other users; chmod 700 it");
  return open_folder;
}

/// The bytes of an object of the cache without its digest; empty if there is none that is whole and
/// the user's own.
std::string whole_object(const Descriptor& folder, const std::string& name) {
  const Descriptor file(
      openat(folder.number(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat facts {};
  if (!file || fstat(file.number(), &facts) != 0 || !S_ISREG(facts.st_mode) || facts.st_uid != geteuid() ||
      (facts.st_mode & 022) != 0 || facts.st_size > largest_object)
    return "";
  std::string bytes(static_cast<std::size_t>(facts.st_size), '\0');
  std::size_t got = 0;
  while (got < bytes.size()) {
    const auto more = read(file.number(), bytes.data() + got, bytes.size() - got);
    if (more <= 0) return "";
    got += static_cast<std::size_t>(more);
  }
  constexpr std::size_t length = 32;
  if (bytes.size() < length) return "";
  const auto end = bytes.substr(bytes.size() - length);
  bytes.resize(bytes.size() - length);
  return digest(bytes) == end && is_whole_object(bytes) ? bytes : "";
}

/// Removes folders of compilations that nobody ended, and all objects if there are too many.
void tidy(const fs::path& folder) {
  constexpr std::chrono::hours abandoned{1};
  std::error_code failed;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    if (!entry.is_directory(failed))
      files.push_back(entry.path());
    else if (entry.last_write_time(failed) < fs::file_time_type::clock::now() - abandoned)
      fs::remove_all(entry.path(), failed);
  }
  if (files.size() < most_objects) return;
  for (const auto& file : files) fs::remove(file, failed);
}

/// Compiles in a folder of its own below the cache folder, which the compiler also uses for its
/// temporary files, appends the digest and renames.
void compile(const fs::path& folder, const std::string& name, const std::string& text,
             const StopToken& stop) {
  static std::atomic<int> count{0};
  tidy(folder);
  const auto place = folder / fmt::format("{}.{}.{}.partial", name, getpid(), ++count);
  if (mkdir(place.c_str(), 0700) != 0) throw refused(place, std::strerror(errno));
  struct Remove {
    const fs::path& folder;
    ~Remove() {
      std::error_code ignored;
      fs::remove_all(folder, ignored);
    }
  } remove{place};
  const auto named = fmt::format("{}\nconst char freeplay_name[] = \"{}\";\n", text, name);
  Child child{.command = compiler(),
              .folder = place,
              .input = named,
              .seconds = longest_compilation,
              .stop = stop,
              .temporary = true};
  child.command.insert(child.command.end(), {"-o", "object", "-", "-lm"});
  const auto end = run_child(child);
  if (end.late) throw Refused{fmt::format("cc took more than {} s", longest_compilation)};
  if (end.status != 0)
    throw Refused{fmt::format("cc failed: {}", visible_brief(end.errors.substr(0, end.errors.find('\n'))))};
  const auto object = place / "object";
  const Descriptor file(open(object.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC));
  struct stat facts {};
  if (!file || fstat(file.number(), &facts) != 0 || facts.st_size > largest_object)
    throw refused(object, "cannot be read back");
  std::string bytes(static_cast<std::size_t>(facts.st_size), '\0');
  if (pread(file.number(), bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw refused(object, "cannot be read back");
  if (!is_whole_object(bytes)) throw Refused{"cc left an incomplete object"};
  const auto end_mark = digest(bytes);
  if (pwrite(file.number(), end_mark.data(), end_mark.size(), facts.st_size) !=
          static_cast<ssize_t>(end_mark.size()) ||
      fchmod(file.number(), 0600) != 0 || rename(object.c_str(), (folder / name).c_str()) != 0)
    throw refused(folder, std::strerror(errno));
}

/// Loads an object of the cache. Nothing if it is not whole, cannot be loaded, was compiled under
/// another name (its functions have other arguments), or has another number of functions; `reason`
/// then says so.
CompiledObject loaded(const Descriptor& open_folder, const fs::path& file, int functions) {
  const auto name = file.filename().string();
  const auto unusable = [&](std::string why) { return CompiledObject{.reason = std::move(why)}; };
  if (whole_object(open_folder, name).empty()) return unusable("is not there any more");
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) return unusable(visible_brief(dlerror()));
  const std::shared_ptr<void> library(handle, dlclose);
  const auto* own = static_cast<const char*>(dlsym(handle, "freeplay_name"));
  if (!own || own != name) return unusable("has another name");
  const auto* table = static_cast<const CompiledFunction*>(dlsym(handle, "freeplay_functions"));
  int count = 0;
  while (table && table[count]) ++count;
  if (count != functions) return unusable("has other functions");
  return {.library = library, .table = table};
}

/// Compilations that failed in this process, with the reasons: the runs of a study do not repeat them.
class Failures {
 public:
  std::string reason(const fs::path& file) const {
    const std::lock_guard lock(mutex_);
    const auto found = reasons_.find(file);
    return found == reasons_.end() ? "" : found->second;
  }
  void add(const fs::path& file, const std::string& reason) {
    const std::lock_guard lock(mutex_);
    reasons_[file] = reason;
  }

 private:
  mutable std::mutex mutex_;
  std::map<fs::path, std::string> reasons_;
};

CompiledObject compiled_now(const Descriptor& open_folder, const fs::path& file, const std::string& text,
                            int functions, const StopToken& stop) {
  static Failures failures;
  if (auto known = failures.reason(file); !known.empty()) throw Refused{std::move(known)};
  try {
    compile(file.parent_path(), file.filename(), text, stop);
    auto object = loaded(open_folder, file, functions);
    if (!object.library) throw refused(file, object.reason.c_str());
    return object;
  } catch (const Refused& r) {
    failures.add(file, r.reason);
    throw;
  }
}

}  // namespace

/// All segments that the loader maps must lie within the file. The loader also maps pages beyond the end
/// of a truncated file, and reading them ends the process by SIGBUS. (System V ABI, "Program Header": a
/// segment has p_filesz bytes from p_offset on. The section table, which the loader does not need, is
/// last in the output of linkers.)
bool is_whole_object(std::string_view bytes) {
  const auto at = [&]<class T>(T& into, std::uint64_t place) {
    if (place > bytes.size() || bytes.size() - place < sizeof into) return false;
    std::memcpy(&into, bytes.data() + place, sizeof into);
    return true;
  };
  ElfW(Ehdr) header;
  if (!bytes.starts_with(ELFMAG) || !at(header, 0)) return false;
  for (std::uint64_t k = 0; k < header.e_phnum; ++k) {
    ElfW(Phdr) segment;
    if (!at(segment, header.e_phoff + k * header.e_phentsize)) return false;
    if (segment.p_offset > bytes.size() || bytes.size() - segment.p_offset < segment.p_filesz) return false;
  }
  const std::uint64_t sections = std::uint64_t{header.e_shnum} * header.e_shentsize;
  return header.e_shoff <= bytes.size() && bytes.size() - header.e_shoff >= sections;
}

CompiledObject compiled_object(const std::string& text, int functions, StopToken stop, bool may_compile) {
  CompiledObject object;
  try {
    const auto folder = user_cache() / "freeplay";
    const auto open_folder = private_folder(folder);
    const auto& identity = compiler_identity(folder);
    if (identity.empty()) throw Refused{"there is no C compiler `cc`"};
    const auto name = digest(fmt::format("{}\n{}\n{}", fmt::join(compiler(), " "), identity, text)) + ".so";
    object = loaded(open_folder, folder / name, functions);
    object.cached = object.library != nullptr;
    if (!object.cached && may_compile)
      object = compiled_now(open_folder, folder / name, text, functions, stop);
  } catch (const Refused& r) {
    object = {};
    object.reason = r.reason;
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& e) {
    object = {};
    object.reason = e.what();
  }
  return object;
}

}  // namespace freeplay
