#include "io/files/compiled_object.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "io/files/child.hpp"
#include "io/files/descriptor.hpp"
#include "io/files/digest.hpp"
#include "io/files/visible.hpp"

namespace freeplay {
namespace {

namespace fs = std::filesystem;

constexpr double longest_compilation = 120;  // s
constexpr off_t largest_object = 64 << 20;   // bytes
/// Above this number of files the cache is emptied.
constexpr int most_objects = 1000;

/// -O1: -O2 takes longer and gains little on straight code; of its parts, one leaves the wide registers
/// of lanes clean.
/// AVX saves moves and has registers for lanes; each of its operations has the digits of the base
/// instruction set, unlike fused multiply-add.
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

/// The compiler's name, version and target; asked once.
const std::string& compiler_identity() {
  static const std::string identity = [] {
    const auto end = run_child({.command = {"cc", "-v"}, .seconds = 10});
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
  return digest(bytes) == end ? bytes : "";
}

void empty_if_full(const fs::path& folder) {
  std::error_code failed;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, failed)) files.push_back(entry.path());
  if (files.size() < most_objects) return;
  for (const auto& file : files) fs::remove(file, failed);
}

/// Compiles into the folder under a name of its own, appends the digest and renames.
void compile(const fs::path& folder, const std::string& name, const std::string& text,
             const StopToken& stop) {
  static std::atomic<int> count{0};
  empty_if_full(folder);
  const auto partial = folder / fmt::format("{}.{}.{}.partial", name, getpid(), ++count);
  struct Remove {
    const fs::path& file;
    ~Remove() {
      std::error_code ignored;
      fs::remove(file, ignored);
    }
  } remove{partial};
  const auto named = fmt::format("{}\nconst char freeplay_name[] = \"{}\";\n", text, name);
  Child child{.command = compiler(), .input = named, .seconds = longest_compilation, .stop = stop};
  child.command.insert(child.command.end(), {"-o", partial.string(), "-", "-lm"});
  const auto end = run_child(child);
  if (end.late) throw Refused{fmt::format("cc took more than {} s", longest_compilation)};
  if (end.status != 0)
    throw Refused{fmt::format("cc failed: {}", visible_brief(end.errors.substr(0, end.errors.find('\n'))))};
  const Descriptor file(open(partial.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC));
  struct stat facts {};
  if (!file || fstat(file.number(), &facts) != 0 || facts.st_size > largest_object)
    throw refused(partial, "cannot be read back");
  std::string bytes(static_cast<std::size_t>(facts.st_size), '\0');
  if (pread(file.number(), bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw refused(partial, "cannot be read back");
  const auto end_mark = digest(bytes);
  if (pwrite(file.number(), end_mark.data(), end_mark.size(), facts.st_size) !=
          static_cast<ssize_t>(end_mark.size()) ||
      fchmod(file.number(), 0600) != 0 || rename(partial.c_str(), (folder / name).c_str()) != 0)
    throw refused(folder, std::strerror(errno));
}

/// Loads an object. Null if it was compiled under another name: its functions have other arguments.
std::shared_ptr<void> loaded(const fs::path& file, const std::string& name) {
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw Refused{visible_brief(dlerror())};
  std::shared_ptr<void> library(handle, dlclose);
  const auto* own = static_cast<const char*>(dlsym(handle, "freeplay_name"));
  return own && own == name ? library : nullptr;
}

}  // namespace

CompiledObject compiled_object(const std::string& text, int functions, StopToken stop) {
  CompiledObject object;
  try {
    const auto& identity = compiler_identity();
    if (identity.empty()) throw Refused{"there is no C compiler `cc`"};
    const auto folder = user_cache() / "freeplay";
    const auto open_folder = private_folder(folder);
    const auto name = digest(fmt::format("{}\n{}\n{}", fmt::join(compiler(), " "), identity, text)) + ".so";
    auto library = whole_object(open_folder, name).empty() ? nullptr : loaded(folder / name, name);
    object.cached = library != nullptr;
    if (!library) {
      compile(folder, name, text, stop);
      if (!whole_object(open_folder, name).empty()) library = loaded(folder / name, name);
      if (!library) throw refused(folder / name, "was changed meanwhile");
    }
    object.table = static_cast<const CompiledFunction*>(dlsym(library.get(), "freeplay_functions"));
    object.library = std::move(library);
    int count = 0;
    while (object.table && object.table[count]) ++count;
    if (count != functions) throw refused(folder / name, "has other functions");
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
