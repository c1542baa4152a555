// Profile files of worn surfaces: what a scene reads from them.
#include "io/scene/read_scene.hpp"
#include "study/wear/wear_documents.hpp"
#include "study/wear/worn_profile.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;

TEST_CASE("a scene reads profile files of wear as the profiles of the next run", "[wear][profiles]") {
  // Both surfaces of the pin of the case, on a rigid foundation.
  constexpr double radius = 10e-3, clearance = 0.5e-3, length = 20e-3, wear = 1e-15;
  WornBearing worn({"pin",
                    {radius, clearance, length, 1e17, 0},
                    wear,
                    wear,
                    std::vector<double>(360),
                    std::vector<double>(360)});
  WearStudy all;
  all.lengths = {length};
  const auto files_of = [&] {
    all.histories = {{"nonsmooth", {{1, 1, 1, {{worn, {}, {}, 0, 0}}}}, WearEnd::turns, 0}};
    return profile_files(all);
  };
  CHECK(files_of().empty());
  BearingLoad load;
  load.on_bearing = 0.5, load.on_journal = 2.5;
  load.force = 100, load.work = 1.5e6;  // wears areas of wear × work/length = 7.5e-8 m²: 20 um deep
  worn.wear(std::vector{load}, 1, 1e-3);
  const auto files = files_of();
  REQUIRE(files.size() == 2);
  CHECK(files[0].name == "profile_bearing_pin_nonsmooth.csv");
  CHECK(files[1].name == "profile_journal_pin_nonsmooth.csv");

  const test::StudyDesk desk("wear-steady");
  const auto unworn = read_scene(desk.at("scene.toml"));
  auto text = test::replaced(test::file_text(desk.at("scene.toml")), "surface = \"steel\"\n",
                             "surface = \"steel\"\nbearing_profile = \"p0\"\njournal_profile = \"p1\"\n");
  for (std::size_t i = 0; i < 2; ++i) {
    desk.put(files[i].name, files[i].points.csv());
    text += fmt::format("[profiles.p{}]\npoints = \"{}\"\n", i, files[i].name);
  }
  const auto read = read_scene(desk.put("scene.toml", text)).mechanism;
  auto next = unworn.mechanism;
  set_worn(next, worn);
  for (std::size_t i = 0; i < 2; ++i) CHECK(read.profiles.at(i).points == next.profiles.at(i).points);
  const auto surfaces_in = [](const Mechanism& m) {
    const auto& joint = *std::ranges::find(m.joints, "pin", [](const Joint& j) { return name_of(j); });
    return out_of_round(m, std::get<RevoluteJoint>(joint)).value();
  };
  const auto a = surfaces_in(read), b = surfaces_in(next);
  REQUIRE(a.arcs.size() == 1);
  CHECK(a.arcs[0].least == b.arcs[0].least);
  for (double phi = 0; phi < 6.28; phi += 0.01) {
    CHECK(a.bearing.at(phi).h == b.bearing.at(phi).h);
    CHECK(a.journal.at(phi).d2 == b.journal.at(phi).d2);
  }
}
