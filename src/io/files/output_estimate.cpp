#include "io/files/output_estimate.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <variant>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "io/files/csv.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/pressure_table.hpp"

namespace freeplay {
namespace {

/// Mean bytes of a number with its comma: of a coordinate or rate, of a force, and of a number that
/// is always 0. Measured on the scenes of docs/reference/security.md.
constexpr double state_width = 20.6, force_width = 19.4, zero_width = 2;
constexpr double event_width = 175, row_of_run_json = 12e3;

/// Mean width of i·step for 0 ≤ i < rows, from a sample of rows.
double time_width(double rows, double step) {
  constexpr int probes = 199;
  double sum = 0;
  for (int i = 0; i < probes; ++i)
    sum += static_cast<double>(fmt::formatted_size("{}", std::floor(rows * (i + 0.5) / probes) * step));
  return sum / probes;
}

std::string size_text(double bytes) {
  constexpr std::array units{"bytes", "kB", "MB", "GB", "TB", "PB"};
  std::size_t i = 0;
  for (; bytes >= 999.5 && i + 1 < units.size(); ++i) bytes /= 1000;
  return fmt::format("{:.3g} {}", bytes, units[i]);
}

/// Coordinates that a single constraint row keeps constant, such as pins on the ground and guides.
std::vector<bool> held(const Scene& scene, const System& system, const State& start) {
  std::vector<bool> found(static_cast<std::size_t>(system.n()));
  const SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic,
                           {!redundant_rows(system, start.q).empty(), scene.run.eliminate});
  for (const int c : saddle.eliminated()) found[static_cast<std::size_t>(c)] = start.v[c] == 0;
  return found;
}

/// Whether a contact counts as closed. A contact of a joint is closed most of the time; any other
/// is taken as in the start. A family of contacts has no gap of its own and counts as closed.
bool touches(const System& system, int contact, const State& start) {
  if (contact >= system.contacts()) return true;
  const auto& facts = system.contact_facts(contact);
  if (facts.has_clearance) return true;
  auto e = system.make_evaluation();
  system.place(start.t, start.q.data(), e);
  return system.gap(contact, start.q.data(), e) < 1e-3 * facts.measure();
}

double forces_row(const Scene& scene, const System& system, const State& start,
                  const std::vector<bool>& constant) {
  double bytes = 0;
  int contact = 0;
  for (const auto& e : system.report().elements) {
    const bool revolute = e.kind == ForceElement::Kind::joint && e.joint >= 0 &&
                          std::holds_alternative<RevoluteJoint>(scene.mechanism.joints[e.joint]);
    const bool open = e.kind == ForceElement::Kind::contact && !touches(system, contact++, start);
    const auto columns = force_parts(e.kind);
    for (const auto& list : {columns.now, columns.mean})
      for (const auto& column : list)
        bytes += open || (revolute && column.second == &ElementForce::m) ? zero_width : force_width;
  }
  for (const bool still : constant) bytes += still ? zero_width : force_width;
  return bytes;
}

double signals(const Scene& scene) {
  double bytes = 0;
  const auto* drive = main_drive(scene.mechanism);
  const double crank = drive && drive->speed != 0 ? force_width : zero_width;
  for (const auto& i : scene.instruments) {
    const double samples = i.sampling * scene.run.duration;
    bytes += samples * (static_cast<double>(i.name.size()) + 2 + time_width(samples, 1 / i.sampling) + crank +
                        force_width);
  }
  return bytes;
}

}  // namespace

double OutputEstimate::bytes() const {
  double sum = 0;
  for (const auto& f : files) sum += f.bytes;
  return sum;
}

std::string OutputEstimate::text() const {
  auto sorted = files;
  std::ranges::sort(sorted, std::greater{}, &File::bytes);
  std::string list;
  for (const auto& f : sorted)
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", f.name, size_text(f.bytes));
  return fmt::format("{} ({})", size_text(bytes()), list);
}

OutputEstimate estimate_output(const Scene& scene, const State& start) {
  const System system(scene.mechanism);
  const auto constant = held(scene, system, start);
  const double step = scene.run.output_step.value_or(scene.run.duration / 20000);
  const double rows = std::ceil(scene.run.duration / step * (1 - 1e-9)) + 1, t = time_width(rows, step);

  OutputEstimate estimate;
  double state = 3 * state_width * system.contacts();
  for (std::size_t c = 0; c < constant.size(); ++c) {
    const auto own = static_cast<double>(fmt::formatted_size("{},", start.q[c]));
    state += constant[c] ? own + zero_width : 2 * state_width;
  }
  estimate.files.push_back({"trajectory.csv", rows * (t + 1 + state)});
  if (scene.run.forces)
    estimate.files.push_back({"forces.csv", rows * (t + 1 + forces_row(scene, system, start, constant))});
  // At most eight columns of a joint.
  if (const auto joints = observed_bearings(scene).size(); joints > 0)
    estimate.files.push_back(
        {"pressure.csv", static_cast<double>(pressure_angles * (1 + 8 * joints)) * state_width});
  if (!scene.instruments.empty()) estimate.files.push_back({"signals.csv", signals(scene)});
  // Batches of the impacts of each contact, and the text of the scene.
  estimate.files.push_back(
      {"run.json and run.checkpoint",
       row_of_run_json + 2.0 * static_cast<double>(scene.text.size()) + 40e3 * system.contacts()});
  if (system.contacts() > 0) estimate.event_bytes = event_width;
  return estimate;
}

void require_room(const Scene& scene, const OutputEstimate& estimate, int copies,
                  const std::filesystem::path& folder, double limit) {
  const double bytes = copies * estimate.bytes();
  const auto what = fmt::format("would write about {}{}", copies > 1 ? fmt::format("{} times ", copies) : "",
                                estimate.text());
  if (bytes > limit)
    throw SceneError(fmt::format(
        "{}: {}, but {} is allowed; use a lower sampling, a greater run.output_step, or --limit-output "
        "{:.0f}",
        scene.file.string(), what, size_text(limit), std::ceil(bytes / 1e9)));
  auto place = std::filesystem::absolute(folder);
  struct statvfs room {};
  while (statvfs(place.c_str(), &room) != 0) {
    if (!place.has_relative_path()) return;  // the output itself will report the error
    place = place.parent_path();
  }
  if (room.f_blocks == 0) return;  // a file system without files
  const double free = static_cast<double>(room.f_bavail) * static_cast<double>(room.f_frsize);
  if (bytes > free)
    throw OutputError(fmt::format("{}: {}, and {} is free there", folder.string(), what, size_text(free)));
}

}  // namespace freeplay
