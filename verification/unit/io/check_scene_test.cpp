// check_scene() refuses what the reader refuses in the canonical text of the same scene, with the
// same key. Each fault changes one member of a valid scene; some of the members have no effect.
#include "io/scene/check_scene.hpp"

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/instruments.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

using Random = std::mt19937;

/// Visitor of keys() that changes the member number `target`, after it has counted all.
class Fault {
 public:
  Fault(int target, Random& random) : target_(target), random_(random) {}

  int members() const { return next_; }
  void apply() const {
    if (change_) change_();
  }

  void all(Scene& scene) {
    auto& m = scene.mechanism;
    if (hit()) change_ = [&m] { m.title = "\xff"; };
    value(m.gravity);
    const auto facts = [&](auto& list) {
      for (auto& x : list) element(x, list.front().name);
    };
    const auto elements = [&](auto& list) {
      for (auto& one : list) std::visit([&](auto& x) { element(x, name_of(list.front())); }, one);
    };
    facts(m.bodies), facts(m.surfaces), facts(m.lubricants), facts(m.profiles), facts(m.curves);
    elements(m.joints), elements(m.contacts), facts(m.groups), elements(m.drives), elements(m.loads);
    Configuration::keys(*this, m.assembly);
    PenaltyOptions::keys(*this, scene.penalty);
    NonsmoothOptions::keys(*this, scene.nonsmooth);
    for (auto& i : scene.instruments) {
      name(i.name, scene.instruments.front().name);
      word(i.kind);
      with_kind(i.kind, [&](auto kind) { kind.keys(*this, i); });
    }
  }

  void need(const Key&, auto& x, const auto&...) { value(x); }
  void take(const Key&, auto& x, const auto&...) { value(x); }
  void flag(const Key&, bool& x) { value(x); }
  void number_or(std::string_view, const Key&, auto& x, const Range&) { value(x); }
  /// The writer looks up the traits of an impact law before its word.
  void choose(const Key& key, auto& x) { key.name == "impact_law" ? void() : word(x); }
  void choose_other(const Key&, auto& x) { word(x); }
  void choose_listed(const Key&, auto& x) { word(x); }
  void choose_some(const Key&, auto& x, const auto&) { word(x); }
  template <class G>
  G* group(std::string_view, std::optional<G>& x) {
    toggle(x);
    return x ? &*x : nullptr;
  }
  bool when(bool) const { return true; }
  bool when(bool holds, std::initializer_list<std::string_view>, const char*) {
    hidden_ = !holds;
    return true;
  }
  bool own(std::string_view, const auto&) const { return true; }
  bool when_given(std::string_view) const { return true; }
  void check(bool, std::string_view, const auto&...) const {}
  void either(const Key&, const Range&, double (*)(double), const Key&, const Range&, auto& x) { value(x); }
  void table(const Key&, const Key&, auto& list) { points(list); }
  void pairs(const Key&, auto& list) { points(list); }
  void samples(const Key&, const Key&, const Key&, auto& list) { points(list); }
  void places(const Key&, const Key&, const Key&, const Key&, const Key&, auto& list) { points(list); }
  void way(const Key&, auto& list) { points(list); }
  void groups(const Key&, std::vector<int>& list) {
    if (hit()) change_ = [&list, i = any({-1, 0, 0, 1, 9999})] { list.push_back(i); };
  }
  void curve(const Key&, int& x, auto...) { index(x); }
  void maybe_curve(const Key&, int& x, auto...) { index(x); }
  void number_or_curve(const Key&, CurveOr& x, const auto&...) { value(x.constant), index(x.curve); }
  void between(std::string_view, auto& pair) { index(pair[0]), index(pair[1]); }
  void ends(std::string_view, auto& at) { value(at[0]), value(at[1]); }
  void points(const Key&, std::string_view, auto&) const {}
  void point_of(const Key&, int, Vec2& x) { value(x); }
  void angles(const Key&, std::vector<JointAngle>& list) {
    if (hit()) change_ = [&list, j = any({-1, 0, 1, 2, 9999})] { list.push_back({{0, 1, j}}); };
  }
  void axis(std::string_view, Vec2& x) { value(x); }
  void radii(const Key&, auto& x) { value(x[0]), value(x[1]); }
  void body(const Key&, int& x) { index(x); }
  const Surface* surface(const Key&, int& x) {
    index(x);
    return nullptr;
  }
  void maybe_surface(const Key&, std::optional<int>& x) {
    if (x) index(*x);
  }
  void lubricant(const Key&, int& x, const auto&...) { index(x); }
  void profile(const Key&, int& x) { index(x); }
  void rows(const Key&, const auto&, auto& list) {
    for (auto& row : list)
      for (double& x : row) value(x);
  }
  void drive(const Key&, std::string& x) {
    if (hit()) change_ = [&x] { x += "x"; };
  }
  template <class J>
  const J* joint(const Key&, int& x) {
    index(x);
    return nullptr;
  }
  template <class... Kinds>
  const Joint* joint_of(const Key&, int& x) {
    index(x);
    return nullptr;
  }
  void moving_joint(const Key&, int& x) { index(x); }
  /// A System looks the joint up also where the key has no effect.
  void maybe_joint(const Key&, int& x) { hidden_ ? void() : index(x); }
  template <class J>
  void maybe_joint_of(const Key&, int& x) {
    index(x);
  }
  void gauge(const Key&, const Key& place, auto& i) {
    if (hit()) change_ = [&x = i.beam] { x += "x"; };
    need(place, i.place, non_negative);
  }
  void any_joint(const Key&, int& x, auto& pair) { index(x), index(pair[0]), index(pair[1]); }
  void joint_place(const Key&, double& x, int) { value(x); }
  void joint_angle(const Key&, double& x, int) { value(x); }
  void ratio_offset(const Key&, double& x, int, int, double) { value(x); }
  void coupled(int, int, const auto&) const {}
  void grounded(int, int) const {}
  void from_bodies(const Key&, auto& x) { value(x); }

 private:
  bool hit() { return next_++ == target_; }
  template <class T>
  T any(std::initializer_list<T> list) const {
    return list.begin()[random_() % list.size()];
  }
  double number(double x) const {
    return any<double>({NAN, INFINITY, -INFINITY, -1.0, 0.0, 1e300, 1e-300, 0.5 * x, 3 * x, -x, x + 1});
  }
  template <class X>
  void element(X& x, const std::string& other) {
    name(x.name, other);
    X::keys(*this, x);
  }
  void name(std::string& x, const std::string& other) {
    if (hit())
      change_ = [&x, to = any<std::string>(
                         {"", "a b", "a.b", "\n", "ground", std::string(101, 'a'), other})] { x = to; };
  }
  void value(double& x) {
    if (hit()) change_ = [&x, to = number(x)] { x = to; };
  }
  void value(bool& x) {
    if (hit()) change_ = [&x] { x = !x; };
  }
  void value(std::integral auto& x) {
    if (hit()) change_ = [&x, to = any({-1, 0, 1, 8, 9})] { x = static_cast<std::decay_t<decltype(x)>>(to); };
  }
  void value(Vec2& v) { value(v.x()), value(v.y()); }
  template <class X>
  void value(std::optional<X>& x) {
    toggle(x);
    if (x) value(*x);
  }
  template <class X>
  void toggle(std::optional<X>& x) {
    if (hit()) change_ = [&x] { x ? x.reset() : void(x.emplace()); };
  }
  void index(int& x) {
    if (hit()) change_ = [&x, to = any({-2, -1, 0, 1, 9999, x + 1})] { x = to; };
  }
  template <class E>
  void word(E& x) {
    if (hit())
      change_ = [&x, by = any({-99, -1, 1, 2, 99})] { x = static_cast<E>(static_cast<int>(x) + by); };
  }
  template <class E>
  void word(std::optional<E>& x) {
    toggle(x);
    if (x) word(*x);
  }
  template <class P>
  void points(std::vector<P>& list) {
    if (list.empty() || !hit()) return;
    auto to = list;
    const auto i = random_() % list.size();
    switch (random_() % 5) {
      case 0:
        to.clear();
        break;
      case 1:
        to.resize(1);
        break;
      case 2:
        to[i] = to.back();
        break;
      case 3:
        std::swap(to[i], to.back());
        break;
      default:
        if constexpr (requires { to[i].first; })
          (random_() % 2 ? to[i].first : to[i].second) = number(to[i].first);
        else
          (random_() % 2 ? to[i].x() : to[i].y()) = number(to[i].x());
    }
    change_ = [&list, to] { list = to; };
  }

  int next_ = 0, target_;
  bool hidden_ = false;
  Random& random_;
  std::function<void()> change_;
};

/// The key of the error of `f`; nullopt if it does not throw.
std::optional<std::string> refused_key(const auto& f) {
  try {
    f();
  } catch (const ModelError& e) {
    return e.key;
  }
  return {};
}

}  // namespace

TEST_CASE("a scene in code is checked as its canonical text is", "[check_scene]") {
  Random random(20);
  int faults = 0, refused = 0;
  for (const auto& file : test::all_scenes()) {
    CAPTURE(file.string());
    const auto scene = read_scene(file);
    REQUIRE_NOTHROW(check_scene(scene));
    auto counted = scene;
    Fault count(-1, random);
    count.all(counted);
    for (int n = 0; n < 25; ++n) {
      auto wrong = scene;
      const auto seed = random();
      CAPTURE(n, seed);
      Random own(seed);
      Fault fault(static_cast<int>(own() % static_cast<unsigned>(count.members())), own);
      fault.all(wrong);
      fault.apply();
      for (auto& body : wrong.mechanism.bodies)  // a System refuses point bodies that keep these
        if (body.point) body.inertia = 0, body.angle = body.angular_velocity = {};
      auto facts = wrong;
      facts.run = {};
      facts.run.duration = 1;
      std::string text;
      const auto read = refused_key([&] {
        text = to_toml(facts);
        parse_scene(text, "");
      });
      const auto checked = refused_key([&] { check_scene(wrong); });
      CAPTURE(text, read.value_or("accepted"), checked.value_or("accepted"));
      CHECK(read.has_value() == checked.has_value());
      // Errors of TOML, such as a table that is there twice, have no key.
      if (read && checked && !read->empty()) CHECK(*read == *checked);
      ++faults;
      refused += read.has_value() ? 1 : 0;
    }
  }
  CHECK(faults >= 1500);
  CHECK(refused >= faults / 4);
}

TEST_CASE("members without effect are not checked", "[check_scene]") {
  auto scene = parse_scene(
      test::body("b", 1, 1) + test::body("c", 1, 1) + test::pin("p", "ground", "b") +
          test::guide("g", "ground", "c") + test::run_for(1) +
          "[curves.v]\nshape = \"constant\"\nvalue = 1\n" + test::drive("push", "g", "force = 1\n") +
          test::drive("turn", "p", "velocity = \"v\"\n") +
          "[loads.force]\ntype = \"force\"\nbody = \"b\"\nforce = [1, 0]\naxes = \"body\"\n"
          "[loads.torque]\ntype = \"torque\"\nbody = \"b\"\ntorque = 1\n"
          "[loads.spring]\ntype = \"spring-damper\"\nbetween = [\"ground\", \"c\"]\n"
          "force_table = [[0, 0], [1, 1]]\none_way = \"pull\"\n"
          "[loads.bushing]\ntype = \"bushing\"\nbetween = [\"ground\", \"b\"]\n"
          "radial_table = [[0, 0], [1, 1]]\n",
      "s.toml");
  auto& m = scene.mechanism;
  std::get<ForceDrive>(m.drives[0]).against = Argument::angle;
  std::get<MotionDrive>(m.drives[1]).of = 0;
  std::get<ForceLoad>(m.loads[0]).against = Argument::position;
  std::get<TorqueLoad>(m.loads[1]).against = Argument::position;
  std::get<SpringDamper>(m.loads[2]).law.cubic = -1;
  std::get<Bushing>(m.loads[3]).stiffness = {-1, -1};
  CHECK_NOTHROW(parse_scene(to_toml(scene), ""));
  CHECK_NOTHROW(check_scene(scene));
}

TEST_CASE("a simulation refuses what a file may not contain", "[check_scene]") {
  const auto given = read_scene(test::flores());
  const auto refused = [&](const std::function<void(Mechanism&)>& change) {
    auto scene = given;
    change(scene.mechanism);
    return test::refusal_of([&] { Simulation(scene, "penalty"); });
  };
  CHECK(refused([](auto&) {}) == "accepted");
  CHECK_THAT(refused([](auto& m) { m.bodies[1].mass = -1; }), Contains("bodies.rod.mass"));
  CHECK_THAT(refused([](auto& m) { std::get<SpeedDrive>(m.drives[0]).joint = 9; }),
             Contains("drives.motor.joint"));
  CHECK(refused([](auto& m) { m.bodies[2].name = "rod"; }) != "accepted");
  auto scene = given;
  scene.run.duration = 0;  // the caller sets the length of the run
  CHECK_NOTHROW(Simulation(scene, "penalty"));
  // A start of another mechanism.
  CHECK_THROWS_AS(Simulation(scene, "penalty", {.start = State{0, {0, 0, 0}, {0, 0, 0}, {}}}), ModelError);
  auto start = assemble(scene.mechanism, RunOptions::Start::assembled);
  start.z = {1};  // no drive of this mechanism has a lag
  for (const char* formulation : {"penalty", "nonsmooth"})
    CHECK_THROWS_AS(Simulation(scene, formulation, {.start = start}), ModelError);
}
