// freeplay export as a user runs it. verification/python/test_export.py reads the files back by
// other programs.
#include <sys/resource.h>
#include <csignal>

#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// A short run of the paper's rig.
std::string made_run(const std::filesystem::path& place) {
  const auto run = place / "run";
  test::succeeded("run " + test::flores().string() +
                  " --formulation nonsmooth --no-figures --set run.revolutions=0.2 --set run.discard=0 -o " +
                  run.string());
  return run.string();
}

bool has_hdf5(const std::string& run) {
  return test::freeplay("export " + run + " --hdf5").err.find("without HDF5") == std::string::npos;
}

std::size_t halves(const std::filesystem::path& folder) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (const auto name = entry.path().filename().string();
        name.ends_with(".partial") || name.starts_with('.'))
      ++count;
  return count;
}

}  // namespace

TEST_CASE("an invalid request to export is refused in one line, and nothing is written", "[export]") {
  test::TemporaryFolder folder;
  const auto place = folder.path().string(), run = made_run(folder.path());
  const bool hdf5 = has_hdf5(run);
  remove_file(folder.path() / "run/results.h5");
  make_folder(folder.path() / "empty");
  const std::pair<std::string, std::string> requested[] = {
      {run, "give a format: --hdf5 [FILE], --vtk [FOLDER] or both"},
      {place + "/nowhere --hdf5", "nowhere: is not a folder"},
      {place + "/empty --vtk", "--vtk: contains no run"},
      {run + " --every 3 --hdf5", "--every requires --vtk"},
      {run + " --vtk --every 0", "--every: must be from 1"},
      {run + " --hdf5 " + place + "/nowhere/a.h5", "does not exist"},
      {run + " --hdf5 " + place + "/run/events.csv", "has the extension of another format"},
      {run + " --hdf5 " + place + "/empty", "is a folder; give a file's name"},
      {place + "/empty --hdf5", hdf5 ? "contains no result tables to export" : "built without HDF5"}};
  for (const auto& [arguments, answer] : requested) {
    CAPTURE(arguments);
    const auto outcome = test::freeplay("export " + arguments);
    CHECK(outcome.status == 2);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains(answer));
  }
  CHECK(std::filesystem::is_empty(folder.path() / "empty"));
  CHECK(!std::filesystem::exists(folder.path() / "run/results.h5"));
  CHECK(!std::filesystem::exists(folder.path() / "run/vtk"));
  CHECK(halves(folder.path()) == 0);
}

TEST_CASE("equal results give equal bytes of HDF5, and no link is followed on writing", "[export]") {
  test::TemporaryFolder folder;
  const auto run = made_run(folder.path());
  if (!has_hdf5(run)) return;
  const auto first = test::file_text(folder.path() / "run/results.h5");
  CHECK(first.substr(1, 3) == "HDF");
  test::succeeded("export " + run + " --hdf5 " + folder.path().string() + "/again.h5");
  CHECK(test::file_text(folder.path() / "again.h5") == first);
  const auto other = folder.path() / "other", link = folder.path() / "link.h5";
  write_file(other, "somebody's");
  std::filesystem::create_symlink(other, link);
  const auto outcome = test::freeplay("export " + run + " --hdf5 " + link.string());
  CHECK(outcome.status == 1);
  CHECK_THAT(outcome.err, Contains("is a symbolic link"));
  CHECK(test::file_text(other) == "somebody's");
  CHECK(halves(folder.path()) == 0);
}

TEST_CASE("a full disk leaves the older export unchanged", "[export]") {
  test::TemporaryFolder folder;
  const auto run = made_run(folder.path());
  const bool hdf5 = has_hdf5(run);
  test::succeeded("export " + run + " --vtk --every 400");
  const auto file = folder.path() / "run/results.h5", series = folder.path() / "run/vtk/mechanism.pvd";
  const auto before = hdf5 ? test::file_text(file) : "", frames = test::file_text(series);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit little{3000, limit.rlim_max};
  setrlimit(RLIMIT_FSIZE, &little);
  const auto outcome = test::freeplay("export " + run + " --hdf5"),
             of_vtk = test::freeplay("export " + run + " --vtk --every 100");
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, handler);
  CHECK(of_vtk.status == 1);
  CHECK(test::file_text(series) == frames);
  if (hdf5) {
    CAPTURE(outcome.err);
    CHECK(outcome.status == 1);
    CHECK_THAT(outcome.err, Contains("results.h5: cannot"));
    CHECK(test::file_text(file) == before);
  }
  CHECK(halves(folder.path()) == 0);
}
