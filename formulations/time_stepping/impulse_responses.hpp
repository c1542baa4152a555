// ImpulseResponses: the rows w of a step's contact problems, each at its place, and the responses A
// w of the mechanism to unit impulses along them (numerics/saddle_point.hpp).
//
// With few contacts, the responses are dense vectors and row r of a problem has place r. With many
// contacts, the rows of each contact have their own places, so that responses are computed once per
// step for all its problems, and responses are stored in sparse form (numerics/responses.hpp).
#pragma once

#include <vector>

#include "dynamics/system.hpp"
#include "numerics/responses.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

class ImpulseResponses {
 public:
  /// `rows`: number of rows of all numbered contacts and friction elements; `many`: each row has
  /// its own place.
  ImpulseResponses(const System& system, int rows, bool many);
  bool many() const { return many_; }

  /// Discards the responses after a new factorisation of the saddle point, which must stay at its
  /// address until the next begin().
  void begin(SaddlePoint& saddle);

  SparseRow& row(int place) { return rows_[place]; }
  const SparseRow& row(int place) const { return rows_[place]; }
  const std::vector<SparseRow>& rows() const { return rows_; }
  const Responses& sparse() const { return sparse_; }
  /// @name Places, with many contacts
  ///@{
  /// of its normal row; the tangential one follows
  int first(int contact) const { return first_[contact]; }
  int friction(int k) const { return friction_[k]; }  ///< of a friction element's row
  ///@}

  /// Computes the response to row(place); with many contacts once per step.
  void respond(SaddlePoint& saddle, int place);
  /// Computes the response to row(place) + factor·`beside` (null: none), with its reactions if
  /// contacts are few.
  void respond(SaddlePoint& saddle, int place, const SparseRow* beside, double factor);
  /// `row` · A w of the row at a place.
  double along(const SparseRow& row, int place) const;
  /// x += by A w
  void push(int place, double by, double* x) const;
  /// @name With few contacts: A w, and the multipliers of the constraint rows with it
  ///@{
  double* response(int place) { return response_.data() + static_cast<long>(place) * n_; }
  const double* response(int place) const { return response_.data() + static_cast<long>(place) * n_; }
  double* reaction(int place) { return reaction_.data() + static_cast<long>(place) * m_; }
  const double* reaction(int place) const { return reaction_.data() + static_cast<long>(place) * m_; }
  ///@}

  /// @name Contacts of pairs, with slots after the numbered contacts
  ///@{
  void add_contact();
  /// Removes all contacts after the first `contacts`.
  void keep_contacts(int contacts);
  /// Discards the responses of a contact whose rows are new.
  void renew(int contact);
  ///@}

 private:
  int n_, m_;
  bool many_;
  std::vector<SparseRow> rows_;
  std::vector<double> response_, reaction_;
  Responses sparse_;
  std::vector<char> taken_;  // responses computed in this step
  std::vector<int> first_, friction_;
};

}  // namespace freeplay
