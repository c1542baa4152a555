#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "dynamics/system.hpp"
#include "facade/run_folder.hpp"
#include "formulations/make.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/scene/read_scene.hpp"
#include "record.hpp"
#include "study/comparison/compare.hpp"
#include "study/sweep/sweep.hpp"
#include "study/sweep/sweep_table.hpp"
#include "values/family.hpp"

namespace py = pybind11;

namespace freeplay::python {
namespace {

/// The output of `freeplay check` for a scene, as values.
py::dict check(const Scene& scene) {
  const UnderWay working;
  const System system(scene.mechanism);
  std::string assumed;
  const auto start = located_in(scene, [&] { return assemble(scene.mechanism, scene.run.start, &assumed); });
  const auto redundant = redundant_rows(system, start.q);
  py::dict d;
  d["bodies"] = system.bodies();
  d["coordinates"] = system.n();
  d["constraint_rows"] = system.rows();
  d["drive_rows"] = system.drive_rows();
  py::list names;
  for (const int row : redundant) names.append(system.row_name(row));
  d["redundant_rows"] = names;
  d["degrees_of_freedom"] = system.n() - system.rows() + static_cast<int>(redundant.size());
  d["contacts"] = system.contacts();
  d["friction_rows_of_joints"] = system.frictions();
  d["instruments"] = scene.instruments.size();
  d["duration_s"] = scene.run.duration;
  d["discard_s"] = scene.run.discard;
  d["assumed"] = assumed;
  d["idle"] = scene.idle;
  py::dict available;
  for (const auto& [family, name] : families) {
    try {
      const auto models = make(family, scene, system, start)->contact_models();
      py::dict contacts;
      for (int k = 0; k < system.reported(); ++k)
        contacts[py::str(system.contact_facts(k).name)] =
            models[static_cast<std::size_t>(k)].restitution_delivered;
      available[name] = contacts;
    } catch (const ModelError& e) {
      available[name] = std::string(e.what());
    }
  }
  d["restitution_delivered"] = available;
  return d;
}

bool compare_into(const Scene& scene, const std::filesystem::path& named, bool matched, StopFlag& flag,
                  bool here) {
  const UnderWay working(true);
  const py::gil_scoped_release unlocked;
  const CtrlC ctrl_c(flag, here);
  ResultSet set(real_folder(named), "compare");
  CompareSetup setup;
  setup.matched = matched;
  setup.stop = flag.token();
  compare(scene, setup, set.place());
  if (!flag.requested) set.commit();
  return ctrl_c.pressed();
}

bool run_into(const Scene& scene, const std::string& formulation, const std::filesystem::path& named,
              bool matched, bool companion, StopFlag& flag, bool here) {
  const UnderWay working;
  const py::gil_scoped_release unlocked;
  const CtrlC ctrl_c(flag, here);
  RunPlan plan;
  plan.formulation = formulation;
  plan.matched = matched;
  plan.folder = real_folder(named);
  plan.stop = flag.token();
  plan.checkpoint = 30;
  plan.companion = companion;
  run_scene(scene, plan);
  return ctrl_c.pressed();
}

/// Computes the missing runs of a study; other processes may work on the same study.
py::dict sweep_into(const std::filesystem::path& file, const std::filesystem::path& named, bool anywhere,
                    int threads, StopFlag& flag, bool here) {
  const UnderWay working(true);
  SweepSummary summary;
  std::string table;
  bool pressed = false;
  {
    const py::gil_scoped_release unlocked;
    const CtrlC ctrl_c(flag, here);
    const Conduct conduct{true, flag.token()};
    const auto study = read_study(file, anywhere ? Reach::anywhere : Reach::beside);
    const auto planned = plan(study, conduct);
    if (!flag.requested) {
      const auto folder = real_folder(named);
      make_folder(folder);
      const FolderLock lock(folder, "sweep", FolderLock::Use::together);
      Results results(folder / "sweep.db", study, flag.token());
      summary = sweep(study, planned, conduct, results, lock, threads, [](const SweepProgress&) {});
      results.derive(study);
      write_sweep_document(study, results, folder);
      if (!summary.interrupted) table = sweep_table(study, results.runs());
    }
    pressed = ctrl_c.pressed();
  }
  py::dict d;
  d["total"] = summary.total;
  d["found"] = summary.found;
  d["ran"] = summary.ran;
  d["failed"] = summary.failed;
  d["elsewhere"] = summary.elsewhere;
  d["interrupted"] = summary.interrupted || flag.requested;
  d["wall_s"] = summary.wall_seconds;
  d["table"] = table;
  d["pressed"] = pressed;
  return d;
}

}  // namespace

void bind_studies(py::module_& m) {
  m.def("check", &check, py::arg("scene"));
  m.def("compare_into", &compare_into, py::arg("scene"), py::arg("folder"), py::arg("matched"),
        py::arg("flag"), py::arg("here"));
  m.def("run_into", &run_into, py::arg("scene"), py::arg("formulation"), py::arg("folder"),
        py::arg("matched"), py::arg("companion"), py::arg("flag"), py::arg("here"));
  m.def("sweep_into", &sweep_into, py::arg("file"), py::arg("folder"), py::arg("anywhere"),
        py::arg("threads"), py::arg("flag"), py::arg("here"));
}

}  // namespace freeplay::python
