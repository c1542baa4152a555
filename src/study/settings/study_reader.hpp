// StudyReader: the visitor that fills a study from one section of its file (mechanism/keys.hpp). To
// the values of any document (io/scene/section.hpp) it adds indices of axes and subtables.
// After the keys of a table were read, finish() checks what concerns several keys, or
// other tables. Errors are SceneErrors with the position of the key.
//
// A reader refers to the section and to the study; it owns neither.
#pragma once

#include <string>
#include <vector>

#include "io/scene/section.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

/// Visitor of the `keys()` functions of a study that reads one section.
class StudyReader : public SectionReader {
 public:
  StudyReader(Section& section, Study& study) : SectionReader(section), study_(study) {}

  void texts(const Key& key, std::vector<Derived>& list);
  void texts(const Key& key, std::vector<std::pair<std::string, std::string>>& units);
  /// The place of the named axis in the study; of axis `otherwise` if the key is absent.
  void axis_of(const Key& key, std::size_t& axis, std::size_t otherwise);
  template <class X>
  void part(const char* name, const char* what, std::optional<X>& x) {
    if (!s_.has(name)) return;
    Section section = s_.child(name);
    x = StudyReader(section, study_).read<X>({}, what);
  }
  template <class X>
  void tables(const char* name, const char* what, std::vector<X>& list) {
    for (auto& [own, section] : s_.children(name)) {
      StudyReader reader(section, study_);
      list.push_back(reader.read(reader.fresh<X>(own), what));
    }
  }
  /// Reads all keys of x and refuses all others.
  template <class X>
  X read(X x, const char* what) {
    X::keys(*this, x);
    finish(x);
    s_.done(what);
    return x;
  }
  void finish(Study& study);

 private:
  /// A new element with the defaults that the study gives.
  template <class X>
  X fresh(const std::string& name) {
    X x;
    x.name = name;
    if constexpr (std::is_same_v<X, Variant>) {
      x.title = name;
      x.scene = study_.scene;
      x.formulations = study_.formulations;
      x.starts = study_.starts.count;
      x.revolutions = study_.length.revolutions;
      x.unknowns = names_of_unknowns();
    }
    return x;
  }
  void finish(Axis& axis);
  void finish(Measure& measure);
  void finish(Variant& variant);
  void finish(Unknown& unknown);
  void finish(Target& x);
  void finish(Calibration& calibration);
  void finish(RowTarget& target);
  void finish(RowClasses& classes) { require_word(classes.name, "classes"); }
  void finish(MeasuredRows& rows);
  void finish(BifurcationPlan& plan) { refuse_varied(plan, {plan.axis}); }
  void finish(BasinPlan& plan) { refuse_varied(plan, {plan.x, plan.y}); }
  void finish(ContinuationPlan& plan);
  void finish(WearPlan& plan);
  void finish_quantity(Target& x);
  void finish_series(Target& x);
  /// Those of [rows].
  std::vector<std::string> names_of_unknowns() const;
  /// Refuses keys that an axis varies and the plan also sets.
  void refuse_varied(const AttractorPlan& plan, std::initializer_list<std::size_t> axes);
  /// Refuses the name of an axis, measure or derived quantity that is already a column of the results.
  void require_free(const std::string& name, const char* what);
  void require_word(const std::string& name, const char* what);

  Study& study_;
};

/// Checks all expressions of the study. Throws SceneError for an invalid one.
void require_expressions(const Study& study);

}  // namespace freeplay
