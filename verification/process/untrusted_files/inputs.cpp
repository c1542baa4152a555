#include "verification/process/untrusted_files/inputs.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "verification/support/support.hpp"

namespace freeplay::test {

Bait::Bait(const std::filesystem::path& place)
    : folder(place / "work"), canary(place / "CANARY"), victim(place / "victim") {
  make_folder(folder);
  write_file(victim, "mine\n");
}

bool Bait::untouched() const {
  if (read_file(victim, 100) != "mine\n") return false;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(canary.parent_path()))
    if (entry.path().filename() == "CANARY") return false;
  return true;
}

std::vector<std::string> hostile_texts(const Bait& bait) {
  const auto touch = "touch " + bait.canary.string();
  using namespace std::string_literals;
  std::vector<std::string> list{
      "`" + touch + "`",
      "$(" + touch + ")",
      "${IFS}; " + touch + " ;",
      "'; system('" + touch + "') #",
      "''''; system('" + touch + "') #",
      "'.system('" + touch + "').'",
      "\"; system(\"" + touch + "\") #",
      "\".system('" + touch + "').\"",
      "\\'; system('" + touch + "') #",
      "\nsystem('" + touch + "')\n",
      "\n!" + touch + "\n",
      "\r\n!" + touch,
      "x\\\n!" + touch,
      "@ARG1 @`" + touch + "`",
      "< " + touch,
      "| " + touch,
      "a'b''c'''d''''e",
      "%s%n%d%99999999d %1$s",
      "$1 $# $$ ${HOME}",
      "#;,=[]{}<>|&~^_@!?*",
      "{/=50 big}_{low}^{high} &{space} @x ~a{b}",
      "\x1b[2J\x1b]0;title\x07\x1b[31mred",
      "back\b\b\bspace \x7f \2331A",
      "\xe2\x80\xae"s + "gnp.elbmif\xe2\x80\xac \xe2\x81\xa6",
      "\xef\xbb\xbf"s + "bom",
      "\xff\xfe\xc0\xaf\xed\xa0\x80\xf5",
      "nul\0nul"s,
      "tab\tand\vfeed\f",
      "../../../CANARY",
      "/../../../CANARY",
      "..",
      "-o",
      "--help",
      "'",
      "\"\"\"",
      "\\",
      "'); DROP TABLE runs; --",
      "<script>alert(1)</script>",
      "ünï©ødé 中文 🙂",
      std::string(100'000, 'A'),
  };
  return list;
}

bool Told::decent() const {
  const auto shows = [](const std::string& text) {
    return std::ranges::none_of(
        text, [](unsigned char c) { return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7f; });
  };
  return status >= 0 && status <= 2 && shows(out) && shows(err) && out.find("\xe2\x80\xae") == out.npos &&
         err.find("\xe2\x80\xae") == err.npos;
}

Told run_program(const Bait& bait, const std::vector<std::string>& arguments) {
  TemporaryFolder folder;
  const auto out = folder.path() / "out", err = folder.path() / "err";
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addchdir_np(&actions, bait.folder.c_str());
  const std::string program = FREEPLAY_BINARY_DIR "/freeplay";
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  pid_t child = 0;
  const int reason = posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (reason != 0) return {127, "", fmt::format("cannot be started: {}", reason)};
  int status = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return {-1, "", "hangs"};
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const auto read = [](const std::filesystem::path& p) {
    std::ifstream in(p, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read(out), read(err)};
}

std::string in_toml(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += std::string("\\") + c;
    else if (byte < 0x20 || byte == 0x7f)
      out += fmt::format("\\u{:04x}", byte);
    else
      out += c;
  }
  return out + "\"";
}

std::string rig(const std::string& title_in_quotes) {
  std::ifstream in(flores());
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto put = [&](const std::string& key, const std::string& value) {
    const auto at = text.find(key);
    text.replace(at, text.find('\n', at) - at, key + value);
  };
  put("title   = ", title_in_quotes);
  put("revolutions = ", "0.05");
  put("discard = ", "0");
  return text;
}

}  // namespace freeplay::test
