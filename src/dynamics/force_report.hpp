// ForceReport: resulting forces of the elements of a System for observers (values/forces.hpp). Each function
// adds `weight` times the given forces; e is from System::place().
//
// An element acts along rows: an amount λ along a row w is the generalised force λ w, whose entries for a
// body are a force and a moment about its centre of mass. The moment about the element's own point P follows:
// m = m_second − (P − c_second) × F. `along` does this for all elements.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/evaluation.hpp"
#include "dynamics/kinematics.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct PlacedElements;  // dynamics/elements.hpp

struct ForceReport {
  /// Constraint rows [begin, end) of an ideal joint or a prescribed motion.
  struct Reaction {
    Link link;
    int begin, end, element;
  };
  /// The elements in the order of forces.csv: ideal joints, contacts, drives, loads.
  std::vector<ForceElement> elements;
  std::vector<Reaction> reactions;
  std::vector<int> contacts, frictions;  ///< indices into elements
  std::vector<Link> contact_links, friction_links;
  std::shared_ptr<const PlacedElements> placed;  ///< drives and loads

  int add(const std::string& name, ForceElement::Kind kind, const std::array<int, 2>& bodies,
          int joint = -1) {
    elements.push_back({name, kind, bodies, joint, true});
    return static_cast<int>(elements.size()) - 1;
  }
  /// Reactions −Gᵀλ of ideal joints and of drives with prescribed motion; `pattern`: that of G.
  void rows(const CsrPattern& pattern, const double* q, const Evaluation& e, const double* lambda,
            double weight, Forces& out) const;
  /// Contact k: forces along its normal and tangent rows.
  void contact(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn, double ft,
               double weight, Forces& out) const {
    contact(k, contact_links[k], q, e, row, fn, ft, weight, out);
  }
  /// Forces of a pair of the family numbered k, added to the family's sum.
  void contact(int k, const Link& link, const double* q, const Evaluation& e, const ContactRow& row,
               double fn, double ft, double weight, Forces& out) const;
  /// Film of contact k: forces along its normal and film rows, and a couple along spin.
  void film(int k, const double* q, const Evaluation& e, const ContactRow& row, double fn, double ft,
            double torque, double weight, Forces& out) const;
  /// Coulomb friction of joint k along its sliding row.
  void friction(int k, const double* q, const double* v, const Evaluation& e, const SparseRow& row,
                double force, double weight, Forces& out) const;
  /// Changes of the forces of elastic rows (System::elastic()) by a small displacement.
  void elastic(const double* q, const Evaluation& e, const double* displacement, double weight,
               Forces& out) const;
  /// Forces of torque drives and loads at a state.
  void loads(double t, const double* q, const double* v, const double* z, const Evaluation& e, double weight,
             Forces& out, const Reading& reading = {}) const;
};

}  // namespace freeplay
