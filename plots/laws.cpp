// Contact and friction laws: hysteresis loops of one free impact, delivered over requested restitution,
// friction over sliding speed. Each curve carries its name at its side or in the key, with dash and colour.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "model/laws.hpp"
#include "plots/figure.hpp"

namespace freeplay::plots {
namespace {

struct Curves {
  std::vector<std::string> names, blocks;
};

/// One block per law, in the order of the file; x and y scaled.
Curves read(const std::filesystem::path& file, const std::string& x, const std::string& y, double sx,
            double sy) {
  const Csv csv(file);
  const auto& law = csv.text("law");
  const auto a = csv.column(x), b = csv.column(y);
  Curves c;
  for (std::size_t i = 0; i < law.size(); ++i) {
    if (c.names.empty() || c.names.back() != law[i]) {
      c.names.push_back(law[i]);
      c.blocks.push_back(fmt::format("# {}: {}, {}\n", law[i], x, y));
    }
    c.blocks.back() += fmt::format("{} {}\n", sx * a[i], sy * b[i]);
  }
  return c;
}

constexpr const char* colours[] = {"#0b3c8c", "#c8500a", "#1b7837", "#7b3294", "#000000", "#888888"};
constexpr const char* dashes[] = {"1", "(14,5)", "(3,4)", "(14,4,3,4)"};

/// plot command for all curves of one kind; `first` is the index of their first block.
std::string plot(const Curves& c, std::size_t first, bool (*chosen)(const std::string&)) {
  std::string text;
  int style = 0;
  for (std::size_t i = 0; i < c.names.size(); ++i) {
    if (!chosen(c.names[i])) continue;
    text += fmt::format("{}'DATA' index {} using 1:2 with lines lc rgb '{}' dt {} lw 1.4 title '{}'",
                        text.empty() ? "plot " : ", ", first + i, colours[style % 6], dashes[style % 4],
                        c.names[i]);
    ++style;
  }
  return text + "\n";
}

bool line_contact(const std::string& name) {
  const auto law = std::ranges::find(contact_laws(), name, &ContactLawFacts::text);
  return law != contact_laws().end() && law->kind == ContactKind::line;
}

std::filesystem::path impact_loops(const std::filesystem::path& folder) {
  const auto c = read(folder / "impact_loops.csv", "delta", "force", 1e6, 1e-3);
  std::ifstream in(folder / "laws.json");
  const auto facts = nlohmann::json::parse(in);
  Figure f;
  f.name = "impact_loops";
  f.source = "laws.json";
  f.blocks = c.blocks;
  const bool lines = std::ranges::any_of(c.names, line_contact);
  f.height_cm = lines ? 19 : 10;
  f.script = fmt::format(
      "set multiplot layout {},1 margins 0.09,0.72,{},0.95 spacing 0,0.12\nset key outside right top "
      "vertical Left reverse\nset xlabel 'Penetration (µm)'\nset ylabel 'Normal force (kN)'\n"
      "set xrange [0:*]\nset yrange [0:*]\nset title 'Point contacts: {:.4g} kg at {:.4g} m/s, e = {:.3g} "
      "asked for'\n{}",
      lines ? 2 : 1, lines ? 0.07 : 0.13, facts.at("mass_kg").get<double>(),
      facts.at("approach_m_per_s").get<double>(), facts.at("restitution_asked").get<double>(),
      plot(c, 0, [](const std::string& n) { return !line_contact(n); }));
  if (lines)
    f.script += "unset label 100\nset title 'Line contacts, the same impact'\n" + plot(c, 0, line_contact);
  f.script += "unset multiplot\n";
  return draw(f, folder);
}

std::filesystem::path delivered_restitution(const std::filesystem::path& folder) {
  const auto c = read(folder / "delivered.csv", "requested", "delivered", 1, 1);
  Figure f;
  f.name = "delivered_restitution";
  f.source = "laws.json";
  f.blocks = c.blocks;
  f.height_cm = 10;
  f.script =
      "set key outside right top vertical Left reverse\nset xlabel 'Restitution asked for'\n"
      "set ylabel 'Restitution delivered in a free impact'\nset xrange [0:1]\nset yrange [0:1.02]\n" +
      plot(c, 0, [](const std::string&) { return true; });
  return draw(f, folder);
}

std::filesystem::path friction_laws(const std::filesystem::path& folder) {
  const auto c = read(folder / "friction.csv", "speed", "coefficient", 1e3, 1);
  Figure f;
  f.name = "friction_laws";
  f.source = "laws.json";
  f.blocks = c.blocks;
  f.script =
      "set key bottom right Left reverse\nset xrange [-5:5]\nset xlabel 'Sliding speed (mm/s)'\nset ylabel "
      "'Friction force / (µ "
      "F_N)'\n" +
      plot(c, 0, [](const std::string&) { return true; });
  return draw(f, folder);
}

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  return {impact_loops(folder), delivered_restitution(folder), friction_laws(folder)};
}

}  // namespace

const Drawing laws{{"laws.json"}, draw_all};

}  // namespace freeplay::plots
