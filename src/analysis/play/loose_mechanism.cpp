#include "analysis/play/loose_mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/closing.hpp"
#include "dynamics/assembly/mobility.hpp"
#include "dynamics/kinematics.hpp"
#include "dynamics/planar.hpp"
#include "mechanism/error.hpp"

namespace freeplay {
namespace {

/// A quantity in the coordinates q.
template <class T>
T evaluate(const OutputQuantity& quantity, const T* q, const EvaluationOf<T>& e) {
  using std::sqrt;
  using Kind = OutputQuantity::Kind;
  if (quantity.kind == Kind::angle) return theta(q, quantity.link.j) - theta(q, quantity.link.i);
  const auto a = arms(quantity.link, q, e);
  switch (quantity.kind) {
    case Kind::x:
      return a.d.x();
    case Kind::y:
      return a.d.y();
    case Kind::slide:
      return dot(turned(quantity.link.i, quantity.axis, e), a.d);
    default:
      return sqrt(dot(a.d, a.d));
  }
}

int body_named(const Mechanism& m, std::string_view name) {
  const auto it = std::ranges::find(m.bodies, name, &Body::name);
  return it == m.bodies.end() ? -2 : static_cast<int>(it - m.bodies.begin());
}

/// A point BODY, BODY.POINT or ground; empty if there is none.
std::optional<std::pair<int, Vec2>> point_named(const Mechanism& m, std::string_view name) {
  if (name == "ground") return std::pair{ground, Vec2{0, 0}};
  if (const int body = body_named(m, name); body >= 0) return std::pair{body, Vec2{0, 0}};
  const auto dot = name.find('.');
  if (dot == name.npos) return {};
  const int body = body_named(m, name.substr(0, dot));
  if (body < 0) return {};
  for (const auto& p : m.bodies[static_cast<std::size_t>(body)].points)
    if (p.name == name.substr(dot + 1)) return std::pair{body, p.at};
  return {};
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

std::optional<OutputQuantity> distance_named(const Mechanism& m, std::string_view name) {
  constexpr std::string_view word = "distance(";
  if (!name.starts_with(word) || !name.ends_with(")")) return {};
  name = name.substr(word.size(), name.size() - word.size() - 1);
  const auto comma = name.find(',');
  if (comma == name.npos) return {};
  const auto one = point_named(m, trimmed(name.substr(0, comma))),
             other = point_named(m, trimmed(name.substr(comma + 1)));
  if (!one || !other) return {};
  return OutputQuantity{
      "", OutputQuantity::Kind::distance, {one->first, other->first, one->second, other->second}};
}

std::optional<OutputQuantity> coordinate_named(const Mechanism& m, std::string_view name) {
  using Kind = OutputQuantity::Kind;
  const auto dot = name.rfind('.');
  if (dot == name.npos) return {};
  const auto point = point_named(m, name.substr(0, dot));
  const auto which = name.substr(dot + 1);
  if (!point || point->first == ground) return {};
  const Link link{ground, point->first, {0, 0}, point->second};
  if (which == "theta" && body_named(m, name.substr(0, dot)) >= 0)
    return OutputQuantity{"", Kind::angle, link};
  if (which != "x" && which != "y") return {};
  return OutputQuantity{"", which == "x" ? Kind::x : Kind::y, link};
}

std::optional<OutputQuantity> joint_named(const Mechanism& m, std::string_view name) {
  for (const auto& joint : m.joints) {
    if (name_of(joint) != name) continue;
    const auto bodies = bodies_of(joint);
    if (const auto* pin = std::get_if<RevoluteJoint>(&joint))
      return OutputQuantity{"", OutputQuantity::Kind::angle, {bodies[0], bodies[1], pin->at[0], pin->at[1]}};
    if (const auto* slide = std::get_if<TranslationalJoint>(&joint))
      return OutputQuantity{
          "", OutputQuantity::Kind::slide, {bodies[0], bodies[1], slide->at[0], slide->at[1]}, slide->axis};
  }
  return {};
}

/// Rank tolerance of F_q, relative.
constexpr double singular = 1e-12;

}  // namespace

double value_of(const OutputQuantity& quantity, const double* q, const Evaluation& e) {
  return evaluate(quantity, q, e);
}

OutputQuantity output_quantity(const Mechanism& m, const std::string& name) {
  for (const auto& find : {coordinate_named, distance_named, joint_named})
    if (auto found = find(m, trimmed(name))) {
      found->name = trimmed(name);
      return *found;
    }
  std::string bodies, joints;
  for (const auto& b : m.bodies) {
    bodies += (bodies.empty() ? "" : ", ") + b.name;
    for (const auto& p : b.points) bodies += ", " + b.name + "." + p.name;
  }
  for (const auto& j : m.joints)
    if (joint_named(m, name_of(j))) joints += (joints.empty() ? "" : ", ") + name_of(j);
  throw ModelError("", fmt::format("\"{}\" is no quantity of this scene; give BODY.x, BODY.y, BODY.theta or "
                                   "POINT.x, POINT.y of {}; distance(POINT, POINT); or a joint of {}",
                                   name, bodies, joints.empty() ? "none" : joints));
}

LooseMechanism::LooseMechanism(const Mechanism& mechanism, const std::vector<OutputQuantity>& quantities,
                               const std::vector<double>& pose, double t,
                               const std::vector<VariedNumber>& varied) {
  const System ideal(idealised(mechanism)), loose(mechanism);
  n_ = ideal.n();
  length_ = length_scale(ideal);
  list_rows(mechanism, ideal, loose);
  if (const int undriven = n_ - static_cast<int>(rows_.size()); undriven > 0) {
    std::string which;
    for (const auto& name : undriven_motions(mechanism, pose).coordinates)
      which += (which.empty() ? "" : ", ") + name;
    throw ModelError("drives", fmt::format("nothing holds {}: the play of a mechanism needs a drive of "
                                           "prescribed motion for each freedom ({} missing)",
                                           which.empty() ? "all motions" : which, undriven));
  }
  quantities_ = static_cast<int>(phi_.size() + contacts_.size());
  radii_ = quantities_ + static_cast<int>(quantities.size());
  const auto object = traced(mechanism, quantities, pose, t, varied.empty());
  point_ = std::make_unique<CurvatureTape<double>>(object, object.function(0));
  box_ = std::make_unique<CurvatureTape<Interval>>(object, object.function(0));
  const auto variables = static_cast<std::size_t>(n_) + 1;
  x_.resize(variables), g_.resize(variables), h_.resize(variables);
  x_box_.resize(variables), g_box_.resize(variables);
  refuse_dependent(mechanism, pose);
  if (!varied.empty()) add_varied(object, varied, quantities, pose, t);
}

TracedObject LooseMechanism::traced(const Mechanism& mechanism, const std::vector<OutputQuantity>& quantities,
                                    const std::vector<double>& pose, double t, bool shared) const {
  const System ideal(idealised(mechanism)), loose(mechanism);
  auto object = shared ? TracedObject() : TracedObject::unshared();
  {
    Trace trace(object, "loose mechanism");
    std::vector<Traced> q;
    for (int c = 0; c < n_; ++c) q.push_back(trace.input(0, c, pose[static_cast<std::size_t>(c)]));
    const Traced time = trace.input(0, n_, t);
    int output = 0;
    auto e = ideal.make_evaluation<Traced>();
    ideal.place(time, q.data(), e);
    for (const int row : phi_) trace.output(0, output++, e.phi[static_cast<std::size_t>(row)]);
    const std::vector<Traced> rest(static_cast<std::size_t>(n_), Traced(0));
    auto with_play = loose.make_evaluation<Traced>();
    with_play.cosine = e.cosine, with_play.sine = e.sine;
    ContactRowOf<Traced> row;
    for (const int k : contacts_) {
      loose.contact(k, q.data(), rest.data(), with_play, row);
      trace.output(0, output++, row.gap);
    }
    for (const auto& quantity : quantities) trace.output(0, output++, evaluate(quantity, q.data(), e));
    // The radii of the discs are constants, too.
    for (const int k : discs_) trace.output(0, output++, Traced(loose.contact_facts(k).clearance));
  }
  return object;
}

void LooseMechanism::add_varied(const TracedObject& stated, const std::vector<VariedNumber>& varied,
                                const std::vector<OutputQuantity>& quantities,
                                const std::vector<double>& pose, double t) {
  constants_ = stated.constants();
  std::vector<char> alone(constants_.size(), 0);  // whether a constant is an operand, not an entry of a table
  for (const auto& node : stated.function(0).nodes)
    if (node.operation == Operation::constant && node.a >= 0) alone[static_cast<std::size_t>(node.a)] = 1;
  for (std::size_t number = 0; number < varied.size(); ++number) {
    const auto& x = varied[number];
    tolerances_.push_back(x.tolerance);
    std::vector<std::vector<double>> constants;
    for (const auto& mechanism : x.mechanisms) {
      std::vector<OutputQuantity> same;
      for (const auto& quantity : quantities) same.push_back(output_quantity(mechanism, quantity.name));
      const auto object = traced(mechanism, same, pose, t, false);
      if (!object.same_structure(stated))
        throw ModelError(x.tolerance.key,
                         "its tolerance changes the equations of the mechanism, which is not described");
      constants.push_back(object.constants());
    }
    const auto [d1, d2] = x.deviations;
    for (std::size_t slot = 0; slot < constants_.size(); ++slot) {
      const double c0 = constants_[slot], c1 = constants[0][slot], c2 = constants[1][slot];
      if (c0 == c1 && c0 == c2) continue;
      if (!alone[slot])
        throw ModelError(x.tolerance.key, "its tolerance changes a table or curve, which is not described");
      const double slope = (c1 - c0) / d1, bend = ((c2 - c0) / d2 - slope) / (d2 - d1);
      varied_.push_back({static_cast<int>(number), slot, slope - d1 * bend, bend});
    }
  }
}

void LooseMechanism::vary(const Eigen::VectorXd& deviations) {
  auto constants = constants_;
  for (const auto& c : varied_) {
    const double d = deviations[c.number];
    constants[c.slot] += d * (c.first + d * c.second);
  }
  point_->set_constants(constants);
}

void LooseMechanism::list_rows(const Mechanism& mechanism, const System& ideal, const System& loose) {
  const auto plain = [&](int row) {
    rows_.push_back({static_cast<int>(phi_.size())});
    phi_.push_back(row);
  };
  for (int row = 0; row < ideal.points(); ++row) plain(row);
  int row = ideal.points(), contact = 0;
  std::vector<std::pair<std::size_t, int>> gaps;  // row and first contact
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const auto& name = name_of(mechanism.joints[j]);
    const int rows = ideal.carried()[j].rows, contacts = loose.carried()[j].contacts;
    const bool ring = contacts > 0 && loose.contact_facts(contact).ring;
    if (contacts > 0 && loose.contact_facts(contact).out_of_round)
      throw ModelError(
          "joints." + name,
          "the play of a bearing or journal with a profile is not described: remove the profile, "
          "or state the clearance of the least gap");
    const auto add = [&](std::string part, bool disc, double clearance) {
      components_.push_back(
          {{name, std::move(part), disc, clearance}, size_, static_cast<int>(rows_.size())});
      size_ += disc ? 2 : 1;
    };
    if (contacts == 0) {
      for (int k = 0; k < rows; ++k) plain(row + k);
    } else if (ring && contacts == 1 && rows == 2) {
      add("", true, loose.contact_facts(contact).clearance);
      discs_.push_back(contact);
      for (int k = 0; k < 2; ++k) {
        plain(row + k);
        rows_.back().radius = static_cast<int>(discs_.size()) - 1;
        rows_.back().component = static_cast<int>(components_.size()) - 1;
        rows_.back().u = components_.back().first + k;
      }
    } else if (!ring && contacts == 2 * rows) {
      for (int k = 0; k < rows; ++k) {
        const int pair = contact + 2 * k;
        add(rows == 1 ? "" : k == 0 ? "rear" : "front", false, loose.contact_facts(pair).clearance);
        rows_.push_back({0, static_cast<int>(components_.size()) - 1, true, components_.back().first});
        gaps.emplace_back(rows_.size() - 1, pair);
      }
    } else {
      throw ModelError("joints." + name,
                       "the play of this kind of joint is not described; describe it by a "
                       "revolute, translational, slot, gear, rack or ratio joint");
    }
    row += rows, contact += contacts;
  }
  for (; row < ideal.rows(); ++row) plain(row);
  for (const auto& [index, pair] : gaps) {
    rows_[index].output = static_cast<int>(phi_.size() + contacts_.size());
    contacts_.insert(contacts_.end(), {pair, pair + 1});
  }
}

void LooseMechanism::refuse_dependent(const Mechanism& mechanism, const std::vector<double>& pose) {
  const System ideal(idealised(mechanism));
  const auto redundant = redundant_rows(ideal, pose);
  if (redundant.empty() && static_cast<int>(rows_.size()) == n_) return;
  const std::string name = redundant.empty() ? "" : ideal.row_name(redundant.front());
  throw ModelError(
      name.empty() ? "joints" : "joints." + name,
      "this joint's constraints depend on those of others, so the joints cannot take all positions "
      "within their clearances; remove the redundant joint or link");
}

bool LooseMechanism::differentiable(const std::vector<double>& q, double t) {
  std::copy(q.begin(), q.end(), x_.begin());
  x_.back() = t;
  return point_->evaluate(x_);
}

bool LooseMechanism::equations(const Eigen::VectorXd& q, const Eigen::VectorXd& u, double t, Equations& f) {
  std::copy(q.begin(), q.end(), x_.begin());
  x_.back() = t;
  if (!point_->evaluate(x_)) return false;
  f.F.resize(n_), f.by_t.resize(n_);
  f.by_q.resize(n_, n_);
  f.by_u.setZero(n_, size_);
  for (int i = 0; i < n_; ++i) {
    const auto& row = rows_[static_cast<std::size_t>(i)];
    const auto k = static_cast<std::size_t>(row.output);
    point_->gradient(k, g_);
    if (row.gaps) {
      const double closing = point_->output(k), other = point_->output(k + 1), part = u[row.u];
      point_->gradient(k + 1, h_);
      f.F[i] = 0.5 * ((1 - part) * other - (1 + part) * closing);
      for (std::size_t c = 0; c < g_.size(); ++c) g_[c] = 0.5 * ((1 - part) * h_[c] - (1 + part) * g_[c]);
      f.by_u(i, row.u) = -0.5 * (closing + other);
    } else {
      f.F[i] = point_->output(k);
      if (row.u >= 0) {
        const double c =
            point_->output(static_cast<std::size_t>(radii_) + static_cast<std::size_t>(row.radius));
        f.F[i] -= c * u[row.u];
        f.by_u(i, row.u) = -c;
      }
    }
    for (int c = 0; c < n_; ++c) f.by_q(i, c) = g_[static_cast<std::size_t>(c)];
    f.by_t[i] = g_.back();
  }
  return true;
}

bool LooseMechanism::close(const Eigen::VectorXd& u, double t, Eigen::VectorXd& q, Equations& f,
                           DenseLu& factors) {
  constexpr int most = 30;
  Eigen::VectorXd step(n_);
  double last = INFINITY;
  for (int i = 0; i < most; ++i) {
    if (!equations(q, u, t, f)) return false;
    factors.compute(f.by_q);
    if (!(factors.pivot_ratio() > singular * singular)) return false;
    factors.solve(f.F, step);
    double size = 0;  // of the step, as a share of the mechanism
    for (int c = 0; c < n_; ++c)
      size = std::max(size, std::abs(step[c]) / (c % planar::coordinates == 2 ? 1 : length_));
    if (!std::isfinite(size) || size > 10) return false;
    // The factors are those of a position that differs by the last step, which is rounding.
    if (size < 4e-16 || (size < 1e-12 && size >= 0.1 * last)) return true;
    q -= step;
    last = size;
  }
  return false;
}

void LooseMechanism::combine(int x, int y, double direction) {
  combination_ = {terms(x)[0], terms(y)[0]};
  combination_[0].weight = std::cos(direction), combination_[1].weight = std::sin(direction);
}

std::array<LooseMechanism::Term, 2> LooseMechanism::terms(int k) const {
  if (k == combined) return combination_;
  return {Term{static_cast<std::size_t>(quantities_) + static_cast<std::size_t>(k), 1}, Term{}};
}

double LooseMechanism::output(int k, Eigen::VectorXd& gradient) {
  double value = 0;
  gradient.setZero(n_);
  for (const auto& term : terms(k)) {
    if (term.weight == 0) continue;
    point_->gradient(term.output, g_);
    gradient += term.weight * Eigen::Map<const Eigen::VectorXd>(g_.data(), n_);
    value += term.weight * point_->output(term.output);
  }
  return value;
}

bool LooseMechanism::enclose(const Poses& poses, double t, Enclosures& f) {
  for (int c = 0; c < n_; ++c) {
    x_[static_cast<std::size_t>(c)] = poses.q[c];
    x_box_[static_cast<std::size_t>(c)] = around(poses.q[c], poses.radius[c]);
  }
  x_.back() = t, x_box_.back() = t;
  if (!point_->evaluate(x_) || !box_->evaluate(x_box_)) return false;
  const auto count = static_cast<Eigen::Index>(components_.size());
  f.by_q.resize(n_, n_), f.by_q_radius.resize(n_, n_);
  f.width_by_q.setZero(count, n_), f.width_by_q_radius.setZero(count, n_);
  std::vector<Interval> weights(box_->outputs(), Interval(0)), second;
  std::vector<double> numbers(weights.size(), 0.0);
  // The gradient of a weighted sum of two gaps from that at q₀ and its second derivatives: interval evaluation of
  // tooth flanks is too wide.
  const auto put = [&](Eigen::MatrixXd& centre, Eigen::MatrixXd& radius, Eigen::Index i, std::size_t k,
                       double first) {
    weights[k] = numbers[k] = first, weights[k + 1] = numbers[k + 1] = 0.5;
    point_->gradient(numbers, g_);
    box_->second(weights, second);
    weights[k] = weights[k + 1] = 0, numbers[k] = numbers[k + 1] = 0;
    Eigen::RowVectorXd H(n_), H_radius(n_);
    for (int j = 0; j < n_; ++j) {
      for (int c = 0; c < n_; ++c) {
        const auto& x = second[static_cast<std::size_t>(j) * x_.size() + static_cast<std::size_t>(c)];
        H[c] = median(x), H_radius[c] = 0.5 * boost::numeric::width(x);
      }
      centre(i, j) = g_[static_cast<std::size_t>(j)];
      radius(i, j) = (H.cwiseAbs() + H_radius).dot(poses.beyond.transpose());
      const Eigen::RowVectorXd along = H * poses.slope, spread = H_radius * poses.slope.cwiseAbs();
      for (const auto& c : components_)
        radius(i, j) += along.segment(c.first, c.size()).norm() + spread.segment(c.first, c.size()).norm();
    }
  };
  for (int i = 0; i < n_; ++i) {
    const auto& row = rows_[static_cast<std::size_t>(i)];
    const auto k = static_cast<std::size_t>(row.output);
    if (row.gaps) {
      put(f.by_q, f.by_q_radius, i, k, -0.5);
      put(f.width_by_q, f.width_by_q_radius, row.component, k, 0.5);
      continue;
    }
    box_->gradient(k, g_box_);
    for (int c = 0; c < n_; ++c) {
      const auto& entry = g_box_[static_cast<std::size_t>(c)];
      f.by_q(i, c) = median(entry), f.by_q_radius(i, c) = 0.5 * boost::numeric::width(entry);
    }
  }
  return true;
}

template <class N, class Put>
void LooseMechanism::each_second(CurvatureTape<N>& tape, int k, double sign, const Eigen::VectorXd& lambda,
                                 const Eigen::VectorXd& u, Put put) {
  std::vector<N> weights(tape.outputs(), N(0)), pair(tape.outputs(), N(0)), second, g(tape.variables());
  for (const auto& term : terms(k))
    if (term.weight != 0) weights[term.output] = sign * term.weight;
  for (int i = 0; i < n_; ++i) {
    const auto& row = rows_[static_cast<std::size_t>(i)];
    const auto output = static_cast<std::size_t>(row.output);
    if (!row.gaps) {
      weights[output] = -lambda[i];
      continue;
    }
    weights[output] = 0.5 * lambda[i] * (1 + u[row.u]);
    weights[output + 1] = -0.5 * lambda[i] * (1 - u[row.u]);
    // ∂²(−λF)/∂q∂u = λ/2 ∇(g₊ + g₋)
    pair[output] = pair[output + 1] = 0.5 * lambda[i];
    tape.gradient(pair, g);
    pair[output] = pair[output + 1] = 0;
    for (int c = 0; c < n_; ++c) {
      put(n_ + row.u, c, g[static_cast<std::size_t>(c)]);
      put(c, n_ + row.u, g[static_cast<std::size_t>(c)]);
    }
  }
  tape.second(weights, second);
  const auto variables = static_cast<std::size_t>(n_) + 1;
  for (int i = 0; i < n_; ++i)
    for (int c = 0; c < n_; ++c)
      put(i, c, second[static_cast<std::size_t>(i) * variables + static_cast<std::size_t>(c)]);
}

void LooseMechanism::second(int k, double sign, const Eigen::VectorXd& lambda, const Eigen::VectorXd& u,
                            Eigen::MatrixXd& H) {
  H.setZero(n_ + size_, n_ + size_);
  each_second(*point_, k, sign, lambda, u, [&](int i, int c, double x) { H(i, c) = x; });
}

void LooseMechanism::enclose_second(int k, double sign, const Eigen::VectorXd& lambda,
                                    const Eigen::VectorXd& u, Eigen::MatrixXd& centre,
                                    Eigen::MatrixXd& radius) {
  centre.setZero(n_ + size_, n_ + size_);
  radius.setZero(n_ + size_, n_ + size_);
  each_second(*box_, k, sign, lambda, u, [&](int i, int c, const Interval& x) {
    centre(i, c) = median(x);
    radius(i, c) = 0.5 * boost::numeric::width(x);
  });
}

}  // namespace freeplay
