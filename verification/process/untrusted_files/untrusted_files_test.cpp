// Texts of untrusted files: each text in each place of a file, in every command that reads the file.
// Nothing in them is executed, nothing outside is written, and no message about them moves a cursor.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include "io/files/output_file.hpp"
#include "verification/process/untrusted_files/inputs.hpp"
#include "verification/support/texts.hpp"

using namespace freeplay;
using namespace std::string_literals;

namespace {

constexpr int any = -1;

/// Files with a text in one place, and the commands that read them. In the files, their names and the
/// commands, @raw is the text itself, @toml the text as a string of TOML, @json the text inside quotes of
/// JSON, @name the text as the name of a file, @word the text as a word of a command line.
struct Input {
  const char* place;
  std::vector<std::pair<std::string, std::string>> files;
  std::vector<std::string> commands;
  int status = any;
};

/// A text as a possible file name; "" if it cannot be one.
std::string as_file_name(std::string text) {
  for (char& c : text)
    if (c == '/' || c == '\0') c = '_';
  text = text.substr(0, 200);
  return text == "." || text == ".." ? "" : text;
}

/// A text inside quotes of JSON: of any bytes, as another program may have written it.
std::string in_json(const std::string& text) {
  const auto quoted = nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::ignore);
  return quoted.substr(1, quoted.size() - 2);
}

std::string filled(const std::string& pattern, const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < pattern.size();) {
    const auto next = [&](std::string_view mark) {
      return std::string_view(pattern).substr(at).starts_with(mark);
    };
    if (next("@raw"))
      out += text, at += 4;
    else if (next("@toml"))
      out += test::in_toml(text), at += 5;
    else if (next("@json"))
      out += in_json(text), at += 5;
    else if (next("@name"))
      out += as_file_name(text), at += 5;
    else if (next("@word"))
      out += text.substr(0, text.find('\0')), at += 5;
    else
      out += pattern[at++];
  }
  return out;
}

/// Tries every n-th combination of an input, a text and a command.
class Trials {
 public:
  explicit Trials(int every) : every_(every), texts_(test::hostile_texts(box_.bait)) {}

  void operator()(const Input& input) {
    for (const auto& text : texts_)
      for (const auto& command : input.commands)
        if (count_++ % every_ == 0) check(input, text, command);
  }

 private:
  void check(const Input& input, const std::string& text, const std::string& command) const {
    CAPTURE(input.place, command, text.substr(0, 100));
    std::filesystem::remove_all(box_.bait.folder);
    for (const auto& [name, content] : input.files) {
      if (name.find("@name") != name.npos && as_file_name(text).empty()) return;
      box_.add(filled(name, text), filled(content, text));
    }
    auto words = test::words_of(command);
    for (auto& word : words) word = filled(word, text);
    const auto outcome = box_.run(words);
    if (input.status != any) CHECK(outcome.status == input.status);
    if (words[0] != "report" || outcome.status != 0) return;
    // The page contains only its own two scripts, whatever the files contain.
    const auto page = test::file_text(box_.at("report.html"));
    CHECK(test::count(page, "<script") == 2);
    CHECK(test::count(page, "</script") == 2);
    CHECK(test::count(page, "<title") == 1);
  }

  int every_, count_ = 0;
  test::Sandbox box_;
  std::vector<std::string> texts_;
};

/// Places in scenes, their options and names.
std::vector<Input> scenes() {
  const auto rig = test::rig("\"rig\""), titled = test::rig("@toml");
  return {
      {"title",
       {{"scene.toml", titled}},
       {"check scene.toml", "run scene.toml --formulation penalty -o out",
        "run scene.toml --formulation nonsmooth -o out", "drift scene.toml -o out", "laws scene.toml -o out",
        "compare scene.toml -o out", "advise scene.toml --error 50", "modes scene.toml",
        "play scene.toml --of slider.x -o out", "play scene.toml --of @word",
        "poincare scene.toml -o out --section @word", "poincare scene.toml -o out --section 'every 0.01 s'"}},
      {"title as it is", {{"scene.toml", test::rig("\"@raw\"")}}, {"check scene.toml"}},
      {"joint", {{"scene.toml", rig + "\n[joints.@toml]\ntype = \"revolute\"\n"}}, {"check scene.toml"}, 2},
      {"value", {{"scene.toml", rig + "\n[loads.l]\ntype = @toml\n"}}, {"check scene.toml"}, 2},
      {"option", {{"scene.toml", rig}}, {"check scene.toml --set joints.gudgeon.surface=@word"}, 2},
      {"name of the file and its folder",  // and of the folder of results
       {{"d/@name/scene.toml", titled}},
       {"run d/@name/scene.toml --formulation nonsmooth", "laws d/@name/scene.toml",
        "run d/@name/scene.toml --formulation nonsmooth --no-figures"}}};
}

/// Places in studies and measurements.
std::vector<Input> studies() {
  const auto rig = test::rig("\"rig\"");
  const std::vector<std::string> commands{"sweep s.toml -o out", "calibrate s.toml -o out",
                                          "validate s.toml -o out", "bifurcation s.toml -o out",
                                          "basin s.toml -o out"};
  auto all = commands;
  all.emplace_back("tradeoff s.toml -o out");  // may take long on a valid study
  const std::string head =
      "scene = \"scene.toml\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\n"
      "revolutions = 1\ndiscard = 0\nstarts = 1\nformulations = [\"nonsmooth\"]\n";
  const std::string settled =
      "scene = \"scene.toml\"\nrevolutions = 1\nstarts = 1\n[axes.a]\nkey = \"surfaces.steel.friction\"\n"
      "values = [0.0, 0.1]\n";
  std::string rows;
  for (int k = 0; k < 20; ++k) rows += fmt::format("0,{},1\n", 0.001 * k);
  const std::string validate = "validate scene.toml --data m.csv --set run.revolutions=1.1 -o out";
  const auto study = [&](const char* place, const std::string& text) {
    return Input{place, {{"scene.toml", rig}, {"s.toml", text}}, commands};
  };
  return {{"title and claims", {{"s.toml", "title = @toml\nclaims = @toml\n"}}, all},
          {"joint and scene", {{"s.toml", "joint = @toml\nscene = @toml\n"}}, all},
          study("axis", head + "[axes.@toml]\nkey = \"run.discard\"\nvalues = [0.0]\n"),
          study("key and unit", head + "[axes.a]\nkey = @toml\nvalues = [1.0]\nunit = @toml\n"),
          study("variant", head + "[variants.@toml]\ntitle = @toml\n"),
          study("scene and options", head + "[variants.a]\nscene = @toml\nset = [@toml]\n"),
          study("fit", head + "fit = @toml\nclaims = \"flores2011\"\n"),
          study("bifurcation", settled + "[bifurcation]\naxis = @toml\nsection = @toml\n"),
          study("columns",
                settled + "[bifurcation]\naxis = \"a\"\nsection = \"every 0.01 s\"\ncolumns = [@toml]\n"),
          study("basin", settled + "[basin]\nx = @toml\ny = \"a\"\nsection = @toml\n"),
          {"header of measurements",
           {{"scene.toml", rig}, {"m.csv", "@raw,t,acceleration\n" + rows}},
           {validate},
           2},
          {"measurement",
           {{"scene.toml", rig}, {"m.csv", "t,acceleration\n0,@raw\n0.001,@raw\n"}},
           {validate},
           2}};
}

/// Places in result folders and in the style of their figures.
std::vector<Input> results() {
  const std::string origin =
      R"("provenance": {"version": "@json", "commit": "@json", "scene_file": "@json", "scene": "@json",
      "overrides": ["@json"], "options": {"run": {"duration": 1.0, "discard": 0.0}}})";
  const std::string plain = R"({"provenance": {"version": "1", "commit": "1", "scene_file": "s"}})",
                    drift = "stabilisation,t,length,closure\nnone,0,1,1\nnone,1,2,2\n";
  const std::vector<std::string> read{"figures .", "report ."};
  std::vector<Input> list{
      {"drift",
       {{"drift.json", "{" + origin + "}"},
        {"drift.csv", "stabilisation,t,length,closure\n@raw,0,1,1\nnone,1,2,2\n"}},
       read},
      {"origin of a drift", {{"drift.json", "{" + origin + "}"}, {"drift.csv", drift}}, read},
      {"name of the folder",
       {{"d/@name/drift.json", plain}, {"d/@name/drift.csv", drift}},
       {"figures d/@name"},
       0},
      {"laws",
       {{"laws.json", R"({"mass_kg": 1, "approach_m_per_s": 1, "contacts": [{"names": ["@json"],
        "restitution_asked": 0.5}], )" +
                          origin + "}"},
        {"impact_loops.csv", "contact,law,delta,force\n@raw,flores,0,0\n@raw,flores,1,1\n@raw,@raw,1,1\n"},
        {"delivered.csv", "law,requested,delivered\nflores,0,0\nflores,1,1\n"},
        {"friction.csv", "law,speed,coefficient\nflores,0,0\nflores,1,1\n"}},
       read},
      {"trade-off",
       {{"tradeoff.json", "{" + origin + R"(, "scenes": {"a": {"scene_file": "@json"}}})"},
        {"tradeoff.csv",
         "scene,method,formulation,events,state,rhs,cpu_s\na,m,penalty,1,1,1,1\na,m,penalty,2,2,2,2\n"
         "@raw,m,penalty,1,1,1,1\n"}},
       read},
      {"extremes",
       {{"extremes.json", "{" + origin + "}"},
        {"extremes.csv",
         "axis,label,value,formulation,outcome\n@raw,1,1,penalty,right\na,@raw,2,penalty,right\n"},
        {"limits.csv", "axis,formulation,value\na,penalty,1\n"}},
       read},
      {"run",
       {{"run.json", R"({"formulation": "@json", "undetermined_reactions": ["@json"], )" + origin + "}"},
        {"forces.csv", "t,@raw.fx_mean,@raw.m_mean,@raw.m\n0,,,\n1,1,1,1\n2,1,2,2\n3,2,1,1\n"}},
       read},
      {"run to repeat or to resume",
       {{"run.json", R"({"formulation": "@json", )" + origin + "}"}},
       {"run --from run.json", "run --resume ."},
       2}};
  Input comparison{"joint and channel",
                   {{"comparison.json",
                     "{" + origin + R"(, "penalty": {"revolutions_counted": 1}, "pairing": {"pairs": []}})"}},
                   read};
  for (const std::string run : {"penalty", "nonsmooth"})
    for (const auto& [name, text] :
         {std::pair<std::string, std::string>{"/trajectory.csv",
                                              "t,@raw.ex,@raw.ey,@raw.gap\n0,0,0,1\n1,0,0,1\n"},
          {"/signals.csv", "channel,t,crank_angle,value\n@raw,0,0,1\n@raw,1,7,1\n"},
          {"/run.json", "{" + origin + "}"}})
      comparison.files.emplace_back(run + name, text);
  list.push_back(comparison);
  for (const char* line :
       {"font = @toml", "font = \"@raw\"", "colours = [@toml]", "size = @toml", "format = @toml",
        "format = [\"pdf\", @toml]", "@toml = 1", "font_size = @toml", "@raw"})
    list.push_back({"style",
                    {{"drift.json", plain}, {"drift.csv", drift}, {"figures/style.toml", line + "\n"s}},
                    {"figures ."},
                    // A comment, an empty line and invalid TOML are no keys of a style.
                    line == "@raw"s ? any : 2});
  return list;
}

void try_all(int every) {
  Trials trials(every);
  for (const auto& list : {scenes(), studies(), results()})
    for (const auto& input : list) trials(input);
}

/// Replaces every string of a document, and every number where `numbers`.
void replace_values(nlohmann::json& at, bool numbers) {
  for (auto& value : at)
    if (value.is_structured())
      replace_values(value, numbers);
    else if (value.is_string() || (numbers && value.is_number()))
      value = "@json";
}

/// A document, or a table, with the mark of a text in its k-th place: the fields of header and first row;
/// strings, strings and numbers. Empty behind the last place.
std::string marked(const std::filesystem::path& file, std::size_t k) {
  const auto text = test::file_text(file);
  if (file.extension() == ".json") {
    auto document = nlohmann::json::parse(text);
    replace_values(document, k == 1);
    return k < 2 ? document.dump(1) : "";
  }
  std::string out;
  std::size_t field = 0;
  for (std::size_t row = 0; const auto& line : test::lines_of(text)) {
    const bool counts = !line.starts_with('#') && row++ < 2;
    auto cells = test::fields_of(line);
    if (counts)
      for (auto& cell : cells)
        if (field++ == k) cell = "@raw";
    out += counts ? fmt::format("{}\n", fmt::join(cells, ",")) : line + "\n";
  }
  return k < field ? out : "";
}

}  // namespace

TEST_CASE("no text of a file is executed: some texts in each place", "[security][untrusted-files]") {
  try_all(37);
}

TEST_CASE("no text of a file is executed: each text in each place and command",
          "[security][untrusted-files][long]") {
  try_all(1);
}

TEST_CASE("no text in the result files of a command is executed", "[security][untrusted-files][long]") {
  const test::Sandbox box;
  box.add("scene.toml", test::rig("\"rig\""));
  const std::string study =
      "title = \"study\"\nscene = \"scene.toml\"\n[axes.mu]\nkey = \"surfaces.steel.friction\"\n"
      "values = [0.0, 0.05]\n[axes.speed]\nkey = \"drives.motor.speed_rpm\"\nvalues = [190, 200]\n";
  const std::string section = "section = \"every 0.01 s\"\nperiod = 0.01\ndiscard = 1\nkeep = 2\n";
  box.add("up.toml", study + "[bifurcation]\naxis = \"mu\"\n" + section);
  box.add("cells.toml", study + "[basin]\nx = \"mu\"\ny = \"speed\"\n" + section);
  Trials trials(53);
  for (const std::string command :
       {"run scene.toml --formulation nonsmooth --no-figures --set run.output_step=1e-4",
        "poincare scene.toml --section 'every 0.01 s'", "bifurcation up.toml", "basin cells.toml",
        "scaling --most 2 --repeat 1", "check scene.toml"}) {
    REQUIRE(box.run(command + " -o made").status == 0);
    std::vector<std::pair<std::string, std::string>> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(box.at("made")))
      if (const auto kind = entry.path().extension(); kind == ".csv" || kind == ".json" || kind == ".toml")
        files.emplace_back(std::filesystem::relative(entry.path(), box.at("made")),
                           test::file_text(entry.path()));
    REQUIRE(!files.empty());
    for (std::size_t f = 0; f < files.size(); ++f)
      for (std::size_t k = 0;; ++k) {
        auto changed = files;
        changed[f].second = marked(box.at("made") / files[f].first, k);
        if (changed[f].second.empty()) break;
        trials(
            {"result file",
             changed,
             {"figures .", "report .", "plot . --x @word --y gudgeon.gap -o @word",
              "plot . --x t --y gudgeon.gap -o @word", "export . --hdf5 --vtk", "animate . --svg --fps 1"}});
      }
    std::filesystem::remove_all(box.at("made"));
  }
}
