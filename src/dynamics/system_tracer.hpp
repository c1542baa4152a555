// SystemTracer: records the functions of a System (system_functions.hpp) at a sample near a state.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "numerics/saddle_point.hpp"
#include "values/state.hpp"

namespace freeplay {

/// Coordinates that one constraint row alone holds at a constant value, at rest: their values.
std::vector<std::optional<double>> still_coordinates(const System& system, const State& at);
/// A state near another one, so that no comparison at it is a tie: journals are not concentric and
/// nothing is at rest. Still coordinates stay.
State moved(const System& system, const State& from, const std::vector<std::optional<double>>& still,
            unsigned seed, double size = 1e-3);

class SystemTracer {
 public:
  /// `size`: of the sample's distance from `near`, see moved().
  SystemTracer(const System& system, const State& near, double size = 1e-3)
      : system_(system),
        still_(still_coordinates(system, near)),
        at_(moved(system, near, still_, 1, size)),
        sample_(system.make_evaluation()) {
    system.place(at_.t, at_.q.data(), sample_);
  }

  void place(TracedObject& object) {
    Trace trace(object, "place");
    const auto e = placed(trace, nullptr);
    cosine_ = e.cosine;
    sine_ = e.sine;
    G_ = e.G;
    for (std::size_t i = 0; i < G_.size(); ++i)
      fixed_.push_back(G_[i].node == trace.old(4, static_cast<int>(i)).node);
  }
  /// The same with curves on pieces (Reading).
  void place_in_pieces(TracedObject& object) const {
    Trace trace(object, "place_in_pieces");
    const auto pieces = pieces_at(trace, 2);
    placed(trace, pieces.data());
  }
  void rate(TracedObject& object) {
    Trace trace(object, "rate");
    const auto q = coordinates(trace, 0, true), v = coordinates(trace, 1, false);
    auto e = fresh(trace);
    orient(trace, 2, e);
    for (std::size_t k = 0; k < e.gamma.size(); ++k) e.gamma[k] = trace.old(0, static_cast<int>(k));
    e.bend = trace.inputs(4, sample_.bend);
    system_.rate(q.data(), v.data(), e);
    trace.outputs(0, e.gamma);
  }
  /// The ways in which tables are evaluated (Reading): at the state, on pieces, or by means over steps.
  enum class Reads { points, pieces, steps };
  static constexpr std::array forces_names{"forces", "forces_in_pieces", "forces_over_step"};
  void forces(TracedObject& object, Reads reads = Reads::points) {
    Trace trace(object, forces_names[static_cast<std::size_t>(reads)]);
    const auto t = trace.input(0, 0, at_.t);
    const auto q = coordinates(trace, 1, true), v = coordinates(trace, 2, false);
    const auto z = trace.inputs(3, at_.z);
    auto e = fresh(trace);
    orient(trace, 4, e);
    std::vector<PieceOf<Traced>> pieces;
    SweepOf<Traced> sweep;
    List start, mean;
    ReadingOf<Traced> reading;
    if (reads == Reads::pieces) {
      pieces = pieces_at(trace, 6);
      reading.pieces = pieces.data();
    } else if (reads == Reads::steps) {
      start = trace.inputs(7, at_.v);
      mean = trace.inputs(8, at_.v);
      sweep = {trace.input(6, 0, 1e-5), start.data(), mean.data()};
      reading.sweep = &sweep;
    }
    system_.forces(t, q.data(), v.data(), z.data(), e, reading);
    trace.outputs(0, e.force);
    trace.output(1, 0, e.power.drive);
    trace.output(2, 0, e.power.load);
    trace.output(3, 0, e.power.damping);
  }
  /// `pattern` gets the columns of the rows, and the values of the spin row.
  void contact(TracedObject& object, int k, const std::string& name, ContactRow& pattern) {
    Trace trace(object, name);
    const auto& bodies = system_.contact_facts(k).bodies;
    const auto of_pair = [&](int c) {
      return planar::body_of(c) == bodies[0] || planar::body_of(c) == bodies[1];
    };
    const auto q = coordinates(trace, 0, true, of_pair), v = coordinates(trace, 1, false, of_pair);
    auto e = fresh(trace);
    orient(trace, 2, e);
    ContactRowOf<Traced> row;
    system_.contact(k, q.data(), v.data(), e, row);
    const auto put = [&](int array, const SparseRowOf<Traced>& from, SparseRow& to) {
      to.size = from.size;
      to.column = from.column;
      for (int i = 0; i < from.size; ++i) {
        to.value[i] = from.value[i].value;
        if (array >= 0)
          trace.output(array, i, from.value[i]);
        else
          (void)value_of(from.value[i]);
      }
    };
    trace.output(0, 0, row.gap);
    put(1, row.normal, pattern.normal);
    put(2, row.tangent, pattern.tangent);
    put(3, row.film, pattern.film);
    put(-1, row.spin, pattern.spin);
    trace.output(4, 0, row.gamma_n);
    trace.output(5, 0, row.gamma_t);
    if (row.film.size == 0) return;  // nobody reads these without a film
    trace.output(6, 0, row.gamma_film);
    trace.output(7, 0, row.turn);
  }
  /// @name Right-hand sides (system_functions.hpp), in motion_kernel.cpp
  ///@{
  /// Whether right-hand sides depend on the state alone, and not on pieces of tables and curves.
  static bool points(const System& system);
  /// Whether the right-hand sides of the event-driven scheme can be one function.
  static bool motions(const System& system);
  /// Record all functions, or throw NotTraceable with none of them in the object.
  void motion(TracedObject& object, const SaddlePoint& saddle);
  void state(TracedObject& object, const SaddlePoint& saddle);
  ///@}
  /// Values of G at the sample, and whether they are constant.
  std::vector<double> G() const { return sample_.G; }
  std::vector<bool> fixed() const {
    auto fixed = fixed_;
    for (std::size_t i = 0; i < G_.size(); ++i)
      if (G_[i].is_constant()) fixed[i] = true;
    return fixed;
  }

  /// @name Arguments of functions that are traced beside those of the System
  ///@{
  using List = std::vector<Traced>;
  /// The sample.
  const State& at() const { return at_; }
  /// q (else v) as inputs of an array. A still coordinate is its value, or its rate 0; a guard checks that.
  List coordinates(Trace& trace, int array, bool positions) const {
    return coordinates(trace, array, positions, [](int) { return true; });
  }
  List coordinates(Trace& trace, int array, bool positions, auto takes) const {
    auto list = trace.inputs(array, positions ? at_.q : at_.v);
    for (std::size_t c = 0; c < list.size(); ++c)
      if (still_[c] && takes(static_cast<int>(c))) {
        const Traced value(positions ? *still_[c] : 0);
        (void)(list[c] == value);
        list[c] = value;
      }
    return list;
  }
  /// The same without guards, for arrays that another function has checked.
  List known_coordinates(Trace& trace, int array, bool positions) const {
    auto list = trace.inputs(array, positions ? at_.q : at_.v);
    for (std::size_t c = 0; c < list.size(); ++c)
      if (still_[c]) list[c] = positions ? *still_[c] : 0;
    return list;
  }
  /// The entries of a list as inputs, except its constants.
  static List inputs_like(Trace& trace, int array, const List& known) {
    auto list = known;
    for (std::size_t i = 0; i < list.size(); ++i)
      if (!list[i].is_constant()) list[i] = trace.input(array, static_cast<int>(i), list[i].value);
    return list;
  }
  /// Outputs the entries that are not those of a new evaluation.
  static void put_changed(Trace& trace, int array, const List& x, const List& fresh) {
    for (std::size_t i = 0; i < x.size(); ++i)
      if (!x[i].is_constant() || x[i].value != fresh[i].value) trace.output(array, static_cast<int>(i), x[i]);
  }
  /// The bodies' orientations as inputs `array` and array + 1, or constants for still bodies.
  void orient(Trace& trace, int array, EvaluationOf<Traced>& e) const {
    for (std::size_t b = 0; b < e.cosine.size(); ++b) {
      const int at = static_cast<int>(b);
      e.cosine[b] = cosine_[b].is_constant() ? cosine_[b] : trace.input(array, at, sample_.cosine[b]);
      e.sine[b] = sine_[b].is_constant() ? sine_[b] : trace.input(array + 1, at, sample_.sine[b]);
    }
  }
  ///@}

 private:
  /// Records the functions `place`.
  EvaluationOf<Traced> placed(Trace& trace, const PieceOf<Traced>* pieces) const {
    const auto t = trace.input(0, 0, at_.t);
    const auto q = coordinates(trace, 1, true);
    auto e = fresh(trace);
    e.pieces = pieces;
    system_.place(t, q.data(), e);
    trace.outputs(0, e.cosine);
    trace.outputs(1, e.sine);
    trace.outputs(2, e.phi);
    trace.outputs(3, e.phi_t);
    trace.outputs(4, e.G);
    trace.outputs(5, e.bend);
    return e;
  }
  void slide(TracedObject& object, const SaddlePoint& saddle, int contact) const;
  EvaluationOf<Traced> whole_state(Trace& trace, const SaddlePoint& saddle, List& v);
  /// The ends of a piece of each phase, as inputs.
  std::vector<PieceOf<Traced>> pieces_at(Trace& trace, int array) const {
    std::vector<PieceOf<Traced>> pieces;
    for (int k = 0; k < system_.phases(); ++k) {
      const auto& phase = system_.phase(k);
      const auto piece = phase.piece(phase.at(at_.q.data(), at_.v.data()).value, true);
      pieces.push_back({trace.input(array, 2 * k, piece.low), trace.input(array, 2 * k + 1, piece.high)});
    }
    return pieces;
  }
  /// An evaluation whose matrix entries are the old ones until they are set.
  EvaluationOf<Traced> fresh(Trace& trace) const {
    auto e = system_.make_evaluation<Traced>();
    const auto old = [&](int array, std::vector<Traced>& list) {
      for (std::size_t i = 0; i < list.size(); ++i) list[i] = trace.old(array, static_cast<int>(i));
    };
    old(3, e.phi_t);
    old(4, e.G);
    return e;
  }
  const System& system_;
  std::vector<std::optional<double>> still_;
  State at_;
  Evaluation sample_;
  std::vector<Traced> cosine_, sine_, G_;
  std::vector<bool> fixed_;
  List whole_G_, whole_F_, whole_phi_t_;  // of whole_state(): constants have no node
};

}  // namespace freeplay
