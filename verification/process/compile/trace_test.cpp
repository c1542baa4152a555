// Traced functions: the C text and its constants, guards, and the cache of compiled objects.
#include <sys/stat.h>

#include "compile/compiled_object.hpp"
#include "compile/compiled_structures.hpp"
#include "numerics/trace.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace fs = std::filesystem;

namespace {

struct PrivateCache : test::CompilerCache {
  fs::path only_object() const {
    const auto all = objects();
    REQUIRE(all.size() == 1);
    return all[0];
  }
};

template <class T>
T polynomial_or_root(const T& x, const T& y, double factor) {
  using std::atan2, std::cos, std::exp, std::sin, std::sqrt, std::tanh;
  if (x > T(1)) return sqrt(x * y) + factor * sin(x) * cos(x);
  return exp(-x) * tanh(y) + atan2(y, x) / (2 * y) - factor;
}

/// The function traced at (x, y), as the object's only one.
TracedObject traced_at(double x, double y, double factor) {
  TracedObject object;
  {
    Trace trace(object, "f");
    const auto X = trace.input(0, 0, x), Y = trace.input(1, 0, y);
    trace.output(0, 0, polynomial_or_root(X, Y, factor));
  }
  return object;
}

/// The value of a function of (x, y); empty if a guard fails.
std::optional<double> call(CompiledFunction f, const TracedObject& object, double x, double y) {
  const auto found = test::call(f, object, {x, y}, 1);
  return found ? std::optional(found->front()) : std::nullopt;
}

}  // namespace

TEST_CASE("a compiled function gives the digits of its template, and refuses the other branch",
          "[compiled]") {
  const PrivateCache cache;
  const auto object = traced_at(2, 3, 0.7), other = traced_at(0.5, 3, 0.7);
  const auto root = compiled_object(object.text(), 1), rest = compiled_object(other.text(), 1);
  REQUIRE(root.reason.empty());
  REQUIRE(rest.reason.empty());
  for (double x = 0.25; x < 4; x += 0.25)
    for (double y = 0.5; y < 3; y += 0.37) {
      const double expected = polynomial_or_root(x, y, 0.7);
      const auto above = call(*root.table, object, x, y), below = call(*rest.table, other, x, y);
      REQUIRE(above.has_value() == (x > 1));
      REQUIRE(below.has_value() == !(x > 1));
      REQUIRE(above.value_or(below.value_or(0)) == expected);
    }
  CHECK_FALSE(call(*root.table, object, NAN, 1));  // no comparison holds for it
}

TEST_CASE("a trace folds zeros and ones, and shares equal operations", "[compiled]") {
  TracedObject object;
  {
    Trace trace(object, "f");
    const auto x = trace.input(0, 0, 2), y = trace.input(0, 1, 3);
    CHECK((x * Traced(0)).is_constant());
    CHECK((x * Traced(1)).node == x.node);
    CHECK((x + Traced(0)).node == x.node);
    CHECK((-(-x)).node == x.node);
    CHECK((x * y).node == (y * x).node);
    CHECK((x - y).node != (y - x).node);
    CHECK((Traced(0.5) * Traced(4)).value == 2);
    trace.output(0, 0, x * y + y * x);
  }
  // Two inputs, one product, one sum.
  CHECK(std::ranges::count_if(object.function(0).uses(), [](int n) { return n > 0; }) == 4);
  CHECK_THROWS_AS(
      [&] {
        Trace trace(object, "g");
        return value_of(trace.input(0, 0, 2));
      }(),
      NotTraceable);
  CHECK(object.functions() == 1);
}

TEST_CASE("a long function is compiled in parts", "[compiled]") {
  const PrivateCache cache;
  // Σ aₖ sin(k x) over many k: numbers of early parts are used in later ones.
  const auto sum = [](const auto& x) {
    using std::sin;
    auto total = x, power = x;
    for (int k = 1; k < 3000; ++k) {
      power = power * x - sin(power);
      total = total + power / double(k) + x;
    }
    return total;
  };
  TracedObject object;
  {
    Trace trace(object, "f");
    trace.output(0, 0, sum(trace.input(0, 0, 0.3)));
  }
  CHECK(object.text().find("f_1(") != std::string::npos);
  const auto compiled = compiled_object(object.text(), 1);
  REQUIRE(compiled.reason.empty());
  for (const double x : {0.3, -0.2, 0.9}) CHECK(call(*compiled.table, object, x, 0) == sum(x));
}

TEST_CASE("the cache of compiled objects: found again, repaired, and private", "[compiled]") {
  const PrivateCache cache;
  const auto object = traced_at(2, 3, 0.7);
  const auto get = [&] { return compiled_object(object.text(), 1); };
  const auto works = [&](const CompiledObject& o) {
    REQUIRE(o.reason.empty());
    CHECK(call(*o.table, object, 2, 3) == polynomial_or_root(2.0, 3.0, 0.7));
  };
  auto first = get();
  works(first);
  CHECK_FALSE(first.cached);
  const auto again = get();
  works(again);
  CHECK(again.cached);
  struct stat facts {};
  REQUIRE(stat(cache.place().c_str(), &facts) == 0);
  CHECK((facts.st_mode & 0777) == 0700);
  const auto file = cache.only_object();
  // Another file under the same name: the loaded object must keep its bytes.
  const auto replace = [&](const std::string& bytes) {
    const auto other = cache.folder.path() / "other";
    write_file(other, bytes);
    fs::permissions(other, fs::perms::owner_read | fs::perms::owner_write);
    fs::rename(other, file);
  };
  auto bytes = test::file_text(file);

  const auto check_repaired = [&] {
    const auto repaired = get();
    works(repaired);
    CHECK_FALSE(repaired.cached);
    CHECK_FALSE(fs::is_symlink(file));
  };
  SECTION("a truncated object is compiled again") {
    replace(bytes.substr(0, bytes.size() / 2));
    check_repaired();
  }
  SECTION("a changed object is compiled again") {
    bytes[64] ^= 1;
    replace(bytes);
    check_repaired();
  }
  SECTION("an object that others may write is not loaded") {
    fs::permissions(file, fs::perms::group_write, fs::perm_options::add);
    check_repaired();
  }
  const auto elsewhere = cache.folder.path() / "elsewhere";
  SECTION("a symbolic link in place of an object is replaced") {
    fs::rename(file, elsewhere);
    fs::create_symlink(elsewhere, file);
    check_repaired();
  }
  SECTION("a folder that others may read is not used") {
    fs::permissions(cache.place(), fs::perms::group_read | fs::perms::others_read, fs::perm_options::add);
    CHECK(get().reason.find("is open to other users") != std::string::npos);
  }
  SECTION("a symbolic link in place of the folder is not followed") {
    fs::rename(cache.place(), elsewhere);
    fs::create_directory_symlink(elsewhere, cache.place());
    CHECK(get().reason.find("symbolic link") != std::string::npos);
  }
  SECTION("a file in place of the folder") {
    fs::remove_all(cache.place());
    std::ofstream(cache.place()) << "x";
    CHECK_FALSE(get().library);
  }
}

// Objects that follow another one (numerics/trace.hpp), and simulations that share compiled functions:
// the result is the one without sharing, whatever is shared.

namespace {

/// Records a random function: `operations` of them, in which a number of `shared` seeds equals that of
/// other functions. Constants are from `scale`.
void record_randomly(TracedObject& object, unsigned shared, unsigned own, int operations, double scale) {
  Trace trace(object, "f");
  std::minstd_rand same(shared), other(own);
  auto list = trace.inputs(0, std::vector{0.3, 0.7, 1.9});
  for (int i = 0; i < operations; ++i) {
    auto& random = i < operations / 2 ? same : other;
    const auto any = [&] { return list[random() % list.size()]; };
    const Traced a = any(), b = random() % 4 == 0 ? Traced(scale * static_cast<double>(random() % 5)) : any();
    const auto kind = random() % 6;
    if (kind == 5)
      (void)(a < b);
    else
      list.push_back(kind == 0 ? a + b : kind == 1 ? a - b : kind == 2 ? a * b : kind == 3 ? -a : sin(a));
  }
  trace.output(0, 0, list.back());
}

TracedObject recorded(unsigned shared, unsigned own, int operations, double scale,
                      const TracedObject* like = nullptr) {
  TracedObject object(0, like);
  record_randomly(object, shared, own, operations, scale);
  record_randomly(object, shared + 1, own + 1, operations, scale);
  return object;
}

Scene slider_crank(std::vector<std::string> changes = {}) {
  changes.insert(changes.end(), {"run.discard=0", "run.revolutions=0.2"});
  return read_scene(test::flores(), changes);
}

State end_of(const Scene& scene, CompiledStructures* structures = nullptr, bool checked = false) {
  Simulation simulation(scene, "nonsmooth",
                        {.compile = Compile::always, .structures = structures, .checked = checked});
  const auto run = simulation.run();
  CHECK(run.compiled.used);
  return run.final_state;
}

}  // namespace

TEST_CASE("an object that follows another one is the object recorded alone", "[compiled]") {
  int shared = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const auto like = recorded(seed, 1000 + seed, 60, 0.3);
    // Equal; with other constants; with other operations from the middle on; shorter; longer; and with
    // constants of 0 and 1, which change the structure.
    struct Follower {
      unsigned own;
      int operations;
      double scale;
    };
    for (const auto& f : {Follower{1000, 60, 0.3},
                          {1000, 60, 0.7},
                          {2000, 60, 0.3},
                          {1000, 40, 0.3},
                          {1000, 90, 0.3},
                          {1000, 60, 1}}) {
      const auto alone = recorded(seed, f.own + seed, f.operations, f.scale),
                 follower = recorded(seed, f.own + seed, f.operations, f.scale, &like);
      CHECK(follower.text() == alone.text());
      CHECK(follower.constants() == alone.constants());
      CHECK(follower.same_structure(alone));
      CHECK(follower.same_structure(like) == alone.same_structure(like));
      shared += follower.same_structure(like) ? 1 : 0;
    }
    // A follower can be followed.
    const auto follower = recorded(seed, 2000 + seed, 60, 0.3, &like);
    CHECK(recorded(seed, 1000 + seed, 60, 0.3, &follower).text() == like.text());
  }
  CHECK(shared >= 40);  // the first of each; the second if no comparison has another result
  CHECK(shared < 240);
}

TEST_CASE("constants that coincide in a follower have one slot, as alone", "[compiled]") {
  const auto sum = [](double a, double b, const TracedObject* like) {
    TracedObject object(0, like);
    {
      Trace trace(object, "f");
      const auto x = trace.input(0, 0, 0.3);
      const auto first = Traced(a) * x;
      trace.output(0, 0, first + Traced(b) * sin(x));
    }
    return object;
  };
  const auto two = sum(2, 3, nullptr), one = sum(2, 2, nullptr);
  CHECK(two.constants() == std::vector<double>{2, 3});
  for (const auto* like : {&two, &one}) {
    CHECK(sum(5, 7, like).constants() == std::vector<double>{5, 7});
    CHECK(sum(5, 5, like).constants() == std::vector<double>{5});
    CHECK(sum(5, 7, like).text() == two.text());
    CHECK(sum(5, 5, like).text() == one.text());
  }
}

TEST_CASE("simulations that share compiled functions have the digits of simulations alone", "[compiled]") {
  const test::CompilerCache cache;
  const std::vector<Scene> scenes{slider_crank(), slider_crank({"joints.gudgeon.clearance=0.4e-3"}),
                                  slider_crank({"surfaces.steel.friction=0"}),
                                  slider_crank({"bodies.rod.mass=2", "drives.motor.speed_rpm=-150"}),
                                  read_scene("cases/four-bar/scene.toml", {"run.revolutions=0.2"})};
  for (const auto& first : scenes) {
    CompiledStructures structures;
    end_of(first, &structures);
    for (const auto& scene : scenes) {
      const auto expected = end_of(scene), found = end_of(scene, &structures);
      CHECK(found.q == expected.q);
      CHECK(found.v == expected.v);
    }
  }
}

TEST_CASE("a scene that is known to be valid is not read again, with the same digits", "[compiled]") {
  auto scene = slider_crank();
  CHECK(end_of(scene, nullptr, true).q == end_of(scene).q);
  scene.mechanism.joints.clear();  // drives and contacts name them
  CHECK_THROWS_AS(Simulation(scene, "nonsmooth"), ModelError);
}
