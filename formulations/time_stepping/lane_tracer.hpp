// LaneTracer: records the functions of steps in lanes (lane_functions.hpp) of one System, from the texts that
// MoreauStepper evaluates (step_text.hpp, formulations/contact/single_contact.hpp). Each function is a
// method.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "dynamics/system_tracer.hpp"
#include "formulations/time_stepping/lane_functions.hpp"
#include "formulations/time_stepping/step_text.hpp"

namespace freeplay {

class LaneTracer {
 public:
  /// Appends the functions to an object, and that which places the sample to another one. `ordinary`: whether
  /// all of them, else only `middle` and `end`.
  LaneTracer(const System& system, const State& near, const SaddlePoint& saddle, bool ordinary,
             TracedObject& object, TracedObject& place)
      // The correction onto the constraints must be as small as in a run.
      : system_(system), tracer_(system, near, 1e-6), saddle_(saddle), ordinary_(ordinary), object_(object) {
    tracer_.place(place);
    middle();
    end();
    if (!ordinary) return;
    for (int k = 0; k < system.contacts(); ++k) contact(k);
    for (int k = 0; k < system.contacts(); ++k) open(k);
    if (system.frictions() > 0) slide();
  }
  int factor_count() const { return static_cast<int>(F_.size()); }
  /// Pivot ratios of each block.
  const std::vector<int>& ratio_counts() const { return ratios_; }

 private:
  using List = std::vector<Traced>;
  using enum LaneArray;
  /// One function, which reads and writes entries of the table by their names.
  class Function {
   public:
    Function(TracedObject& object, const std::string& name) : trace(object, "lanes_" + name) {}
    Traced in(LaneArray array, int i = 0, double sample = 1) {
      return trace.input(static_cast<int>(array), i, sample);
    }
    List list(LaneArray array, int size, int first = 0) {
      List list;
      for (int i = 0; i < size; ++i) list.push_back(in(array, first + i));
      return list;
    }
    List list(LaneArray array, const std::vector<double>& sample) {
      return trace.inputs(static_cast<int>(array), sample);
    }
    /// A row whose entries are inputs, if they are not constant.
    SparseRowOf<Traced> row(LaneArray array, SparseRowOf<Traced> x, int first = 0) {
      for (int i = 0; i < x.size; ++i) x.value[i] = in(array, first + i, x.value[i].value);
      return x;
    }
    void out(LaneArray array, int i, const Traced& x) { trace.output(static_cast<int>(array), i, x); }
    void out(LaneArray array, const List& x, int first = 0) {
      for (std::size_t i = 0; i < x.size(); ++i) out(array, first + static_cast<int>(i), x[i]);
    }
    void out(LaneArray array, const SparseRowOf<Traced>& x, int first = 0) {
      for (int i = 0; i < x.size; ++i) out(array, first + i, x.value[i]);
    }
    /// Entries that differ from those before, where a condition holds.
    void change(LaneArray array, const Traced& where, const List& before, const List& x, int first = 0) {
      for (std::size_t i = 0; i < x.size(); ++i)
        if (x[i].node != before[i].node)
          out(array, first + static_cast<int>(i), select(where, x[i], before[i]));
    }
    Trace trace;
  };
  /// The joint friction with a given force: its row, rate and last impulse, and the responses to it.
  struct Slide {
    SparseRowOf<Traced> row;
    Traced bias, bound, last;  // m/s; N s
    List response, reaction;
  };
  /// v, λ, momentum and v₀, to which a function adds impulses.
  struct Motion {
    List v, lambda, momentum, v_old;
  };

  void middle();
  void contact(int k);
  void slide();
  void end();
  void open(int k);

  std::size_t n() const { return static_cast<std::size_t>(system_.n()); }
  std::size_t m() const { return static_cast<std::size_t>(system_.rows()); }
  /// The known positions or rates.
  List coordinates(Function& f, LaneArray array, bool positions) const {
    return tracer_.known_coordinates(f.trace, static_cast<int>(array), positions);
  }
  List like(Function& f, LaneArray array, const List& known) const {
    return tracer_.inputs_like(f.trace, static_cast<int>(array), known);
  }
  /// The evaluation at the middle, of which only the orientations are known.
  EvaluationOf<Traced> oriented(Function& f) const {
    auto e = system_.make_evaluation<Traced>();
    tracer_.orient(f.trace, static_cast<int>(cosine), e);  // and sine, which follows
    return e;
  }
  Motion motion(Function& f) const {
    return {f.list(v, tracer_.at().v), f.list(lambda, system_.rows()), f.list(momentum, system_.n()),
            f.list(v_old, tracer_.at().v)};
  }
  void change(Function& f, const Traced& where, const Motion& before, const Motion& now) const {
    f.change(v, where, before.v, now.v);
    f.change(lambda, where, before.lambda, now.lambda);
    f.change(momentum, where, before.momentum, now.momentum);
  }
  List mean(const Motion& x) const {
    List list(n());
    mean_of(n(), x.v_old.data(), x.v.data(), list.data());
    return list;
  }
  /// Adds an impulse P along a row to a motion, with the responses of v and λ to it.
  static void add(Motion& x, const Traced& P, const SparseRowOf<Traced>& row, const List& a,
                  const List& reaction) {
    for (std::size_t i = 0; i < x.v.size(); ++i) x.v[i] += P * a[i];
    for (std::size_t k = 0; k < x.lambda.size(); ++k) x.lambda[k] += P * reaction[k];
    row.add_to(x.momentum.data(), P);
  }
  void respond(const List& G, const List& F, const SparseRowOf<Traced>& row, List& a, List& reaction) const {
    List f(n());
    row.add_to(f.data(), Traced(1));
    saddle_.trace_solution(G, F, f, List(m()), a, reaction);
  }
  std::optional<Slide> slide_of(Function& f, const Traced& h, const List& G, const List& F) const;
  Traced reach_of(Function& f, int k, const Traced& h, const List& v) const;
  Traced gap_at(int k, const List& q, const EvaluationOf<Traced>& e) const {
    const List rest(q.size());
    ContactRowOf<Traced> row;
    system_.contact(k, q.data(), rest.data(), e, row);
    return row.gap;
  }
  /// Totals with the greatest |Φ| in m and in rad, where a condition holds.
  void put_residuals(Function& f, const Traced& where, const EvaluationOf<Traced>& e) const;

  const System& system_;
  SystemTracer tracer_;
  const SaddlePoint& saddle_;
  bool ordinary_;
  TracedObject& object_;
  // of middle(): constants have no node
  List G_, F_, phi_t_;
  std::vector<int> ratios_;
  std::vector<ContactRowOf<Traced>> rows_;
  SparseRowOf<Traced> slide_row_;
  Traced slide_gamma_;
};

}  // namespace freeplay
