#include "verification/process/untrusted_files/inputs.hpp"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>

#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"

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

bool decent(const Outcome& o) {
  const auto shows = [](const std::string& text) {
    return text.find("\xe2\x80\xae") == text.npos && std::ranges::none_of(text, [](unsigned char c) {
             return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
           });
  };
  return o.status >= 0 && o.status <= 2 && shows(o.out) && shows(o.err);
}

void Sandbox::add(const std::filesystem::path& name, const std::string& text) const {
  make_folder(at(name).parent_path());
  write_file(at(name), text);
}

Outcome Sandbox::run(const std::string& command) const { return run(words_of(command)); }

Outcome Sandbox::run(const std::vector<std::string>& words) const {
  auto outcome = run_program(words);
  INFO(fmt::format("{}", fmt::join(words, " ")).substr(0, 300));
  INFO("status " << outcome.status << "\n" << outcome.err.substr(0, 1000));
  CHECK(decent(outcome));
  CHECK(bait.untouched());
  return outcome;
}

Outcome Sandbox::run_program(const std::vector<std::string>& words) const {
  const auto out = folder.path() / "out", err = folder.path() / "err";
  const auto command = fmt::format(
      "cd {} && timeout 60 {}/freeplay {} >{} 2>{} </dev/null", shell_words({bait.folder.string()}),
      FREEPLAY_BINARY_DIR, shell_words(words), shell_words({out.string()}), shell_words({err.string()}));
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), file_text(out), file_text(err)};
}

std::vector<std::string> words_of(const std::string& command) {
  std::vector<std::string> words(1);
  bool quoted = false;
  for (const char c : command)
    if (c == '\'')
      quoted = !quoted;
    else if (c == ' ' && !quoted)
      words.emplace_back();
    else
      words.back() += c;
  return words;
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
  auto text = file_text(flores());
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
