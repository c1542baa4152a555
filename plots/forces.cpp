// What the joints and drives carry: reactions and driving torques over the crank angle, and polar load
// diagrams of the revolute joints, both formulations over the ideal mechanism. All are means over intervals
// of time, impulses included, the one measure of force that an impact law and a contact force share. Of a
// driven mechanism the last whole turn, else the whole run. Impacts make rare means far beyond all others:
// ranges follow a quantile where these would flatten the rest, and the figure says how many points lie
// outside.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "model/scene.hpp"
#include "plots/figure.hpp"
#include "io/output_file.hpp"

namespace freeplay::plots {
namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr std::size_t most_points = 2000;  ///< of a curve; more rows are merged
constexpr std::size_t most_panels = 6;
constexpr std::size_t most_joints = 12;  ///< drawn, loose ones first
constexpr double share = 0.99;           ///< quantile of a range's upper end; of its lower one, 1 less it
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

using Values = std::vector<double>;
constexpr const char* corners[] = {"rear_lower", "rear_upper", "front_lower", "front_upper"};

/// Means of one run, each over the time since the row before.
struct Means {
  Values t;                        ///< s, of the rows: one more than there are means
  std::vector<std::string> names;  ///< without their suffix _mean, in the order of the file
  std::map<std::string, Values> of;
};

/// One run as it is drawn.
struct Run {
  const char* title;
  int style;
  Means means;
  Values x;                        ///< degrees or s, of the middle of each interval
  double interval = 0;             ///< s, that a mean is over
  const char* part = "whole run";  ///< which is drawn

  const Values* find(const std::string& name) const {
    const auto it = means.of.find(name);
    return it == means.of.end() ? nullptr : &it->second;
  }
};

/// Reads the columns of means alone: a file has several others per joint. An empty field is NaN.
Means read_means(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!in || !std::getline(in, line)) throw OutputError(file.string() + ": cannot be read");
  Means m;
  std::vector<Values*> place;
  const auto fields = [&](const auto& take) {
    std::size_t count = 0;
    for (std::size_t from = 0; from <= line.size(); ++count) {
      const auto to = line.find(',', from);
      if (to != line.npos) line[to] = '\0';
      take(count, line.c_str() + from);
      from = to == line.npos ? line.size() + 1 : to + 1;
    }
    return count;
  };
  fields([&](std::size_t, const char* field) {
    const std::string name = field;
    place.push_back(name == "t" ? &m.t : nullptr);
    if (!name.ends_with("_mean")) return;
    m.names.push_back(name.substr(0, name.size() - 5));
    place.back() = &m.of[m.names.back()];
  });
  for (std::size_t row = 2; std::getline(in, line); ++row) {
    const auto count = fields([&](std::size_t i, const char* field) {
      if (i >= place.size() || !place[i]) return;
      char* end = nullptr;
      const double x = std::strtod(field, &end);
      if (row > 2 || place[i] == &m.t) place[i]->push_back(end == field ? nothing : x);
    });
    if (count != place.size())
      throw OutputError(
          fmt::format("{}: line {} has {} fields, its header {}", file.string(), row, count, place.size()));
  }
  return m;
}

/// The scene that a run's run.json carries, when this program can read it.
std::optional<Scene> scene_of(const std::filesystem::path& run) {
  std::ifstream in(run / "run.json");
  const auto document = nlohmann::json::parse(in, nullptr, false);
  if (document.is_discarded() || !document.contains("provenance")) return {};
  const auto& p = document["provenance"];
  try {
    return parse_scene(p.value("scene", ""), p.value("scene_file", ""),
                       p.value("overrides", std::vector<std::string>{}));
  } catch (const std::exception&) {
    return {};
  }
}

/// Keeps the last whole turn and places each mean in the middle of its interval. A turn begins where the
/// angle is a multiple of 360°; when the run holds no such turn, its last 360° are kept, wrapped round.
void keep_last_turn(Run& run, const SpeedDrive* drive) {
  const auto& t = run.means.t;
  const std::size_t n = t.empty() ? 0 : t.size() - 1;
  std::size_t first = 0, last = n;
  for (std::size_t i = 0; i < n; ++i) run.x.push_back(0.5 * (t[i] + t[i + 1]));
  if (drive && n > 0) {
    const auto turns = [&](double time) {
      return std::copysign(1, drive->speed) * (drive->initial_angle + drive->speed * time) / turn;
    };
    constexpr double rounding = 1e-6;
    double begin = std::floor(turns(t.back()) + rounding) - 1;
    run.part = "last turn";
    if (begin < turns(t.front()) - rounding) {
      begin = turns(t.back()) - 1;
      run.part = begin < turns(t.front()) - rounding ? "whole run" : "last 360°";
    }
    for (auto& x : run.x) x = turns(x);
    while (first < n && run.x[first] < begin) ++first;
    while (last > first && run.x[last - 1] > begin + 1) --last;
    for (auto& x : run.x) x = 360 * (x - std::floor(x));
  }
  const auto cut = [&](Values& v, std::size_t to) {
    v.erase(v.begin() + static_cast<std::ptrdiff_t>(to), v.end());
    v.erase(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(first));
  };
  cut(run.x, last);
  cut(run.means.t, std::min(last + 1, t.size()));
  for (auto& [name, v] : run.means.of) cut(v, last);
}

/// Joins `count` intervals at a time into one.
void merge(Run& run, std::size_t count) {
  const auto t = run.means.t;
  const std::size_t n = run.x.size();
  const auto joined = [&](const Values& v, bool angle) {
    Values out;
    for (std::size_t i = 0; i < n; i += count) {
      double sum = 0;
      const std::size_t end = std::min(i + count, n);
      // An angle that jumps back to 0 has no mean.
      if (angle && v[end - 1] < v[i]) {
        out.push_back(v[i]);
        continue;
      }
      for (std::size_t k = i; k < end; ++k) sum += v[k] * (t[k + 1] - t[k]);
      out.push_back(sum / (t[end] - t[i]));
    }
    return out;
  };
  for (auto& [name, v] : run.means.of) v = joined(v, false);
  run.x = joined(run.x, true);
  if (n > 0) run.interval = t[std::min(count, n)] - t[0];
}

struct Range {
  double low = 0, high = 0;
  std::vector<std::size_t> outside;  ///< points of each run

  std::string note(const std::vector<Run>& runs) const {
    std::string list;
    for (std::size_t r = 0; r < outside.size(); ++r)
      if (outside[r] > 0)
        list += fmt::format("{}{} {} of {}", list.empty() ? "" : ", ", runs[r].title, outside[r],
                            runs[r].x.size());
    return list;
  }
};

/// Of one quantity in all runs. Its extremes, unless they are thrice as far apart as the quantiles.
Range range_of(const std::vector<Values>& runs) {
  Range range;
  double low = INFINITY, high = -INFINITY, least = INFINITY, greatest = -INFINITY;
  for (const auto& values : runs) {
    Values v;
    std::ranges::copy_if(values, std::back_inserter(v), [](double x) { return std::isfinite(x); });
    if (v.empty()) continue;
    std::ranges::sort(v);
    const auto tail = static_cast<std::size_t>((1 - share) * static_cast<double>(v.size()));
    low = std::min(low, v[tail]);
    high = std::max(high, v[v.size() - 1 - tail]);
    least = std::min(least, v.front());
    greatest = std::max(greatest, v.back());
  }
  if (!(least <= greatest)) return {0, 1, {}};
  if (greatest - least <= 3 * (high - low) || high == low) low = least, high = greatest;
  const double margin = 0.06 * (high - low);
  range.low = low - margin;
  range.high = high + margin;
  for (const auto& values : runs)
    range.outside.push_back(static_cast<std::size_t>(
        std::ranges::count_if(values, [&](double x) { return x < range.low || x > range.high; })));
  return range;
}

/// Widens a range of rounding errors to `least`.
void widen(Range& range, double least) {
  const double lack = least - (range.high - range.low);
  if (!(lack > 0)) return;
  range.low -= 0.5 * lack;
  range.high += 0.5 * lack;
}

struct Panel {
  std::string quantity, name;  ///< ylabel; what stands above the panel
  std::vector<Values> runs;    ///< empty where a run has none of it
  bool from_zero = false;
};

double greatest(const std::vector<Values>& runs) {
  double g = 0;
  for (const auto& values : runs)
    for (double x : values)
      if (std::isfinite(x)) g = std::max(g, std::abs(x));
  return g;
}

Values length(const Values& x, const Values& y) {
  Values out;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) out.push_back(std::hypot(x[i], y[i]));
  return out;
}

/// For gnuplot's single quotes.
std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out;
}

std::string file_name(const std::string& joint) {
  std::string out = joint;
  for (char& c : out)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '_';
  return out;
}

class Forces {
 public:
  Forces(const std::filesystem::path& folder, std::vector<std::pair<std::filesystem::path, Run>> runs)
      : folder_(folder) {
    for (auto& [path, run] : runs) {
      if (!scene_) scene_ = scene_of(path);
      run.means = read_means(path / "forces.csv");
      if (run.means.t.size() > 2) runs_.push_back(std::move(run));
    }
    if (scene_) drive_ = main_drive(scene_->mechanism);
    if (drive_ && drive_->speed == 0) drive_ = nullptr;
    std::size_t longest = 0;
    for (auto& run : runs_) {
      keep_last_turn(run, drive_);
      longest = std::max(longest, run.x.size());
    }
    for (auto& run : runs_) merge(run, std::max<std::size_t>(1, (longest + most_points - 1) / most_points));
    for (const auto& run : runs_) interval_ = std::max(interval_, run.interval);
  }

  std::vector<std::filesystem::path> all() {
    std::vector<std::filesystem::path> made;
    const auto keep = [&](const std::filesystem::path& path) {
      if (!path.empty()) made.push_back(path);
    };
    for (const auto& name : joints()) {
      keep(reaction(name));
      if (revolute(name)) keep(bearing_load(name));
    }
    keep(drive_torque());
    return made;
  }

 private:
  /// A force with a moment is a joint's or a contact's; a force without one is a load.
  std::vector<std::string> joints() const {
    std::vector<std::string> list;
    for (const auto& run : runs_)
      for (const auto& column : run.means.names) {
        if (!column.ends_with(".m")) continue;
        auto name = column.substr(0, column.size() - 2);
        for (const auto* corner : corners)
          if (name.ends_with(std::string(".") + corner)) name.resize(name.size() - std::strlen(corner) - 1);
        if (std::ranges::find(list, name) == list.end()) list.push_back(name);
      }
    if (list.size() > most_joints) {
      std::ranges::stable_partition(list, [&](const std::string& name) { return loose(name); });
      list.resize(most_joints);
    }
    return list;
  }
  const Joint* joint(const std::string& name) const {
    if (!scene_) return nullptr;
    const auto& list = scene_->mechanism.joints;
    const auto it = std::ranges::find(list, name, [](const Joint& j) { return name_of(j); });
    return it == list.end() ? nullptr : &*it;
  }
  bool revolute(const std::string& name) const {
    const auto* j = joint(name);
    return j && std::holds_alternative<RevoluteJoint>(*j);
  }
  bool loose(const std::string& name) const {
    const auto* j = joint(name);
    return j && std::visit(
                    [](const auto& x) {
                      if constexpr (requires { x.clearance; })
                        return x.clearance.has_value();
                      else
                        return false;
                    },
                    *j);
  }
  /// What a force figure is headed with.
  std::string heading(const std::string& name) const {
    const auto* j = joint(name);
    const int body = j ? bodies_of(*j)[1] : ground;
    return escaped(!j ? name + ": force on the second body"
                      : fmt::format("{}: force on {}", name,
                                    body == ground ? "the ground" : scene_->mechanism.bodies[body].name));
  }
  /// A column of every run; of a loose guide the sum over its corners.
  std::vector<Values> columns(const std::string& name, const char* suffix) const {
    std::vector<Values> list;
    for (const auto& run : runs_) {
      Values sum;
      if (const auto* v = run.find(name + suffix)) sum = *v;
      for (const auto* corner : corners)
        if (const auto* v = run.find(name + "." + corner + suffix)) {
          sum.resize(v->size(), 0.0);
          std::ranges::transform(sum, *v, sum.begin(), std::plus<>());
        }
      if (std::ranges::none_of(sum, [](double x) { return std::isfinite(x); })) sum.clear();
      list.push_back(std::move(sum));
    }
    return list;
  }
  std::vector<Values> magnitudes(const std::string& name) const {
    auto x = columns(name, ".fx");
    const auto y = columns(name, ".fy");
    for (std::size_t r = 0; r < x.size(); ++r) x[r] = length(x[r], y[r]);
    return x;
  }
  bool any(const std::string& column) const {
    return std::ranges::any_of(runs_, [&](const Run& run) { return run.find(column) != nullptr; });
  }

  /// Panels one above the other over the same angle or time.
  std::filesystem::path stack(const std::string& name, const std::string& heading, std::vector<Panel> panels,
                              double least) const {
    std::erase_if(panels, [](const Panel& p) {
      return std::ranges::all_of(p.runs, [](const Values& v) { return v.empty(); });
    });
    if (panels.empty()) return {};
    Figure f;
    f.name = name;
    const double each = panels.size() == 1 ? 6.5 : panels.size() < 5 ? 3.1 : 2.6;
    const double gap = 0.55, top = 1.1, bottom = 1.35;
    const double count = static_cast<double>(panels.size());
    f.height_cm = top + bottom + count * each + (count - 1) * gap;
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      std::string block = fmt::format("# {}: {}", runs_[r].title, drive_ ? "angle (degrees)" : "t (s)");
      for (const auto& p : panels) block += ", " + (p.name.empty() ? "" : p.name + " ") + p.quantity;
      block += "\n";
      for (std::size_t i = 0; i < runs_[r].x.size(); ++i) {
        if (drive_ && i > 0 && runs_[r].x[i] < runs_[r].x[i - 1]) block += "\n";
        block += fmt::format("{:.6g}", runs_[r].x[i]);
        for (const auto& p : panels)
          block += fmt::format(" {:.6g}", p.runs[r].empty() ? nothing : p.runs[r][i]);
        block += "\n";
      }
      f.blocks.push_back(block);
    }
    f.script = fmt::format(
        "set multiplot layout {},1 margins 0.1,0.975,{:.4f},{:.4f} spacing 0,{:.4f}\n"
        "set key at screen 0.975,{:.4f} right top horizontal\n"
        "set label 1 '{}' at screen 0.1,{:.4f} noenhanced\nset format x ''\n{}",
        panels.size(), bottom / f.height_cm, 1 - top / f.height_cm, gap / f.height_cm, 1 - 0.15 / f.height_cm,
        heading, 1 - 0.32 / f.height_cm, drive_ ? "set xrange [0:360]\nset xtics 45\n" : time_range());
    for (std::size_t k = 0; k < panels.size(); ++k) {
      auto& p = panels[k];
      auto range = range_of(p.runs);
      widen(range, least);
      if (p.from_zero) range.low = 0;
      const auto note = range.note(runs_);
      if (k + 1 == panels.size())
        f.script += fmt::format("set format x\nset xlabel '{}' offset 0,0.3\n", abscissa());
      f.script += fmt::format(
          "set ylabel '{}'\nset yrange [{:.5g}:{:.5g}]\n"
          "set label 2 '{}' at graph 0, graph 1 offset 0,0.5 font ',7' noenhanced\n"
          "set label 3 '{}' at graph 1, graph 1 offset 0,0.5 right font ',6.5' tc rgb '#555555'\n",
          p.quantity, range.low, range.high, escaped(p.name),
          note.empty() ? "" : "outside the range (99 % quantile): " + note);
      std::string plot;
      for (int style : {1, 2, 3})
        for (std::size_t r = 0; r < runs_.size(); ++r)
          if (runs_[r].style == style && !p.runs[r].empty())
            plot += fmt::format("{}'DATA' index {} using 1:{} with lines ls {}{} title '{}'",
                                plot.empty() ? "plot " : ", ", r, k + 2, style,
                                style == 3 ? " lw 1.4" : " lw 1.1", runs_[r].title);
      f.script += plot + "\n";
      if (k == 0) f.script += "unset key\nunset label 1\nunset label 100\n";
    }
    f.script += "unset multiplot\n";
    return draw(f, folder_);
  }
  std::string time_range() const {
    double end = 0;
    for (const auto& run : runs_) end = std::max(end, run.means.t.back());
    return fmt::format("set xrange [0:{:.6g}]\n", end);
  }
  /// Which part of the run is drawn, and what the means are over.
  std::string extent() const { return fmt::format("{}, means over {}", runs_.front().part, interval()); }
  std::string interval() const {
    return interval_ < 1e-3 ? fmt::format("{:.3g} µs", 1e6 * interval_)
                            : fmt::format("{:.3g} ms", 1e3 * interval_);
  }
  std::string abscissa() const {
    return fmt::format("{}: {}", drive_ ? "Crank angle (°)" : "Time (s)", extent());
  }

  std::filesystem::path reaction(const std::string& name) const {
    const auto size = magnitudes(name);
    const double rounding = std::max(1e-6 * greatest(size), 1e-9);
    std::vector<Panel> panels;
    const bool guide = any(name + "." + corners[0] + ".fx");
    panels.push_back({"|F| (N)", guide ? "all corners" : "", size, true});
    if (guide) {
      for (const auto* corner : corners)
        if (any(name + "." + corner + ".fx")) {
          std::string label = corner;
          std::ranges::replace(label, '_', ' ');
          panels.push_back({"|F| (N)", label, magnitudes(name + "." + corner), true});
        }
    } else {
      // A component that is nothing but rounding, such as a revolute joint's moment, has no panel; a moment's
      // arm is of the order of a metre or less.
      for (const auto& [quantity, suffix] :
           {std::pair{"F_x (N)", ".fx"}, std::pair{"F_y (N)", ".fy"}, std::pair{"M (N m)", ".m"}})
        if (auto v = columns(name, suffix); greatest(v) > rounding)
          panels.push_back({quantity, "", std::move(v), false});
    }
    return stack("reaction_" + file_name(name), heading(name), std::move(panels), rounding);
  }

  std::filesystem::path drive_torque() const {
    std::vector<Panel> panels;
    double size = 0;
    for (const auto& run : runs_)
      for (const auto& column : run.means.names) {
        if (!column.ends_with(".torque")) continue;
        const auto name = column.substr(0, column.size() - 7);
        const auto is = [&](const Drive& d) {
          return std::visit([](const auto& x) { return x.name; }, d) == name;
        };
        if (scene_ && std::ranges::none_of(scene_->mechanism.drives, is)) continue;
        if (std::ranges::find(panels, name, &Panel::name) != panels.end() || panels.size() == most_panels)
          continue;
        panels.push_back({"Torque (N m)", name, columns(name, ".torque"), false});
        size = std::max(size, greatest(panels.back().runs));
      }
    if (panels.empty()) return {};
    return stack("drive_torque", "", std::move(panels), std::max(1e-6 * size, 1e-9));
  }

  /// Fx against Fy, a panel for each formulation with the ideal joint in it.
  std::filesystem::path bearing_load(const std::string& name) const {
    const auto x = columns(name, ".fx"), y = columns(name, ".fy");
    auto across = range_of(x), up = range_of(y);
    // The origin in sight, the same scale on both axes.
    for (auto* range : {&across, &up}) {
      const double margin = 0.06 * (range->high - range->low);
      range->low = std::min(range->low, -margin);
      range->high = std::max(range->high, margin);
    }
    const double span = std::max({across.high - across.low, up.high - up.low, 1e-9});
    widen(across, span);
    widen(up, span);

    Figure f;
    f.name = "bearing_load_" + file_name(name);
    std::vector<std::size_t> panels;
    std::optional<std::size_t> ideal;
    for (std::size_t r = 0; r < runs_.size(); ++r) {
      std::string block = fmt::format("# {}: F_x, F_y (N)\n", runs_[r].title);
      for (std::size_t i = 0; i < std::min(x[r].size(), y[r].size()); ++i)
        block += fmt::format("{:.6g} {:.6g}\n", x[r][i], y[r][i]);
      const bool none = x[r].empty() || y[r].empty();
      f.blocks.push_back(none ? block + "NaN NaN\n" : block);  // gnuplot does not count a block without rows
      if (none) continue;
      if (runs_[r].style == 3)
        ideal = r;
      else
        panels.push_back(r);
    }
    if (panels.empty()) return {};
    f.width_cm = panels.size() == 1 ? 9 : 16;
    f.height_cm = 9;
    f.script = fmt::format(
        "set multiplot layout 1,{} margins {},0.98,0.135,0.835 spacing 0.11,0\nset size ratio -1\n"
        "set xrange [{:.5g}:{:.5g}]\nset yrange [{:.5g}:{:.5g}]\nset xlabel 'F_x (N)' offset 0,0.4\n"
        "set ylabel 'F_y (N)' offset 0.8\nset xzeroaxis ls 4\nset yzeroaxis ls 4\n"
        "set label 1 '{}' at screen 0.02,0.965 noenhanced\nset key at screen 0.98,0.99 right top\n"
        "set title offset 0,-0.6\n"
        "set label 2 '{}' at screen 0.02,0.922 font ',6.5' tc rgb '#555555'\n",
        panels.size(), panels.size() == 1 ? 0.15 : 0.09, across.low, across.high, up.low, up.high,
        heading(name), extent());
    for (std::size_t k = 0; k < panels.size(); ++k) {
      const auto r = panels[k];
      std::size_t outside = 0;
      for (std::size_t i = 0; i < x[r].size(); ++i)
        outside += x[r][i] < across.low || x[r][i] > across.high || y[r][i] < up.low || y[r][i] > up.high;
      f.script += fmt::format(
          "set title \"{}{}\"\nplot 'DATA' index {} using 1:2 with lines ls {} lw 0.8 dt 1 notitle",
          runs_[r].title,
          outside == 0
              ? ""
              : fmt::format("\\n{{/*0.8 outside the range (99 % quantile): {} of {}}}", outside, x[r].size()),
          r, runs_[r].style);
      if (ideal)
        f.script += fmt::format(", 'DATA' index {} using 1:2 with lines ls 3 lw 1.4 {}", *ideal,
                                k == 0 ? "title 'ideal joint'" : "notitle");
      f.script += "\n";
      if (k == 0) f.script += "unset label 1\nunset label 2\nunset label 100\n";
    }
    f.script += "unset multiplot\n";
    return draw(f, folder_);
  }

  std::filesystem::path folder_;
  std::optional<Scene> scene_;
  const SpeedDrive* drive_ = nullptr;  ///< of scene_
  std::vector<Run> runs_;
  double interval_ = 0;  ///< s
};

}  // namespace

std::vector<std::filesystem::path> forces(const std::filesystem::path& folder) {
  std::vector<std::pair<std::filesystem::path, Run>> runs;
  const auto add = [&](const std::filesystem::path& path, const char* title, int style) {
    if (std::filesystem::exists(path / "forces.csv")) runs.push_back({path, {title, style, {}, {}, 0}});
  };
  if (std::filesystem::exists(folder / "comparison.json")) {
    add(folder / "penalty", "penalty", 1);
    add(folder / "nonsmooth", "nonsmooth", 2);
    add(folder / "ideal", "ideal joint", 3);
  } else if (std::filesystem::exists(folder / "run.json")) {
    std::ifstream in(folder / "run.json");
    const auto document = nlohmann::json::parse(in, nullptr, false);
    const bool nonsmooth = !document.is_discarded() && document.value("formulation", "") == "nonsmooth";
    add(folder, nonsmooth ? "nonsmooth" : "penalty", nonsmooth ? 2 : 1);
  }
  if (runs.empty()) return {};
  return Forces(folder, std::move(runs)).all();
}

}  // namespace freeplay::plots
