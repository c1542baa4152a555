#include "verification/random_scenes/draft.hpp"

#include <algorithm>

namespace freeplay::verification::random_scenes {

DrawnCurve draw_curve(Draw& draw, const CurveWish& wish) {
  DrawnCurve c;
  auto& s = c.shape;
  using Kind = CurveShape::Kind;
  const double T = wish.period, A = wish.size;
  const int dice = draw.whole(0, 9);
  const auto number = [&](const char* key, double& to, double value) {
    to = exact(value);
    c.lines += fmt::format("{} = {}\n", key, text_of(value));
  };
  if (dice < 3) {
    s.kind = Kind::harmonic;
    c.lines = "shape = \"harmonic\"\n";
    number("amplitude", s.amplitude, A);
    if (draw.chance(0.5)) number("mean", s.mean, A * draw.either_way(1));
    if (wish.place && draw.chance(0.5)) {
      double f = 0;
      number("frequency", f, 1 / T);
      s.period = 1 / f;
    } else {
      number("period", s.period, T);
    }
    if (draw.chance(0.7)) number("phase", s.phase, draw.angle());
  } else if (dice < 6) {
    const bool once = draw.chance(0.3) || dice == 5;
    s.kind = dice == 5 ? Kind::ramp : Kind::rise_dwell_return;
    c.lines = fmt::format("shape = \"{}\"\n", dice == 5 ? "ramp" : "rise-dwell-return");
    if (draw.chance(0.5)) number("from", s.from, A * draw.either_way(0.5));
    number("to", s.to, s.from + A * draw.sign());
    number("start", s.start, T * draw.between(0, once ? 2 : 1));
    number("rise", s.rise, T * draw.between(0.15, 0.4));
    s.cycloidal = draw.chance(0.5);
    c.lines += fmt::format("profile = \"{}\"\n", s.cycloidal ? "cycloidal" : "polynomial");
    if (dice < 5) {
      s.dwell = 0;
      if (draw.chance(0.7)) number("dwell", s.dwell, T * draw.between(0.02, 0.3));
      number("return", s.fall, T * draw.between(0.15, 0.4));
      if (!once) {
        if (draw.chance(0.7)) number("rest", s.rest, T * draw.between(0.02, 0.4));
        s.repeats = true;
        c.lines += "repeat = true\n";
      }
    }
  } else {
    s.kind = wish.place || draw.chance(0.5) ? Kind::spline : Kind::lines;
    s.ends = wish.place ? CurveShape::Ends::flat : CurveShape::Ends::free;
    s.repeats = draw.chance(0.7);
    const int n = draw.whole(4, 8);
    std::string points;
    double x = T * draw.between(0, 0.5), first = 0;
    for (int i = 0; i <= n; ++i) {
      double y = A * draw.either_way(1);
      if (i == 0) first = y;
      if (i == n && s.repeats) y = first;
      s.points.emplace_back(exact(x), exact(y));
      points += fmt::format("{}[{}, {}]", i ? ", " : "", text_of(x), text_of(y));
      x += T / n * draw.between(0.7, 1.3);
    }
    c.lines = fmt::format("shape = \"table\"\npoints = [{}]\n", points);
    if (s.kind == Kind::spline) c.lines += "between = \"spline\"\n";
    if (s.repeats) c.lines += "repeat = true\n";
  }
  s.prepare();
  c.period = T;
  return c;
}

DrivenMotion::DrivenMotion(DrawnCurve curve, bool rate, double initial, double until)
    : curve_(std::move(curve)), integrated_(rate), initial_(initial) {
  period = curve_.period;
  kinks_ = curve_.shape.kinks(0, 1.01 * until);
  if (integrated_) {
    const long n = std::clamp(static_cast<long>(1.01 * until / period * 40), 10L, 400000L);
    grid_ = 1.01 * until / static_cast<double>(n);
    sums_.push_back(0);
    for (long i = 0; i < n; ++i)
      sums_.push_back(sums_.back() + curve_.shape.integral(static_cast<double>(i) * grid_,
                                                           static_cast<double>(i + 1) * grid_, period / 40));
  }
  const double first = at(0).y;
  for (int i = 0; i <= 4000; ++i) {
    const auto p = at(until * i / 4000);
    size = std::max(size, std::abs(p.y - first));
    this->rate = std::max(this->rate, std::abs(p.slope));
    bend = std::max(bend, std::abs(p.bend));
  }
}

CurvePoint DrivenMotion::at(double t) const {
  const auto p = curve_.shape.at(t);
  if (!integrated_) return p;
  const auto i = std::min(static_cast<std::size_t>(std::max(t, 0.0) / grid_), sums_.size() - 1);
  const double from = static_cast<double>(i) * grid_;
  return {initial_ + sums_[i] + curve_.shape.integral(from, t, period / 40), p.y, p.slope};
}

double DrivenMotion::next_kink(double t) const {
  const auto next = std::upper_bound(kinks_.begin(), kinks_.end(), t * (1 + 1e-14));
  return next == kinks_.end() ? INFINITY : *next;
}

}  // namespace freeplay::verification::random_scenes
