// Rows w of a step's contact problems, each in its place, and the responses A w of the mechanism to a unit of impulse along
// them (numerics/saddle_point.hpp).
//
// With few contacts the responses are whole vectors, and a problem's row r has the place r. With many each contact's rows
// have their own places, so that what a step has computed of them serves all its problems, and responses are stored where
// they are not zero (numerics/responses.hpp).
#pragma once

#include <vector>

#include "dynamics/system.hpp"
#include "numerics/responses.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

class ImpulseResponses {
 public:
  /// `rows`: of all contacts and friction elements that have a number; `many`: each has its own place.
  ImpulseResponses(const System& system, int rows, bool many);
  bool many() const { return many_; }

  /// Forgets the responses: the saddle point is factorised anew. It stays where it is until the next begin().
  void begin(SaddlePoint& saddle);

  SparseRow& row(int place) { return rows_[place]; }
  const SparseRow& row(int place) const { return rows_[place]; }
  const std::vector<SparseRow>& rows() const { return rows_; }
  const Responses& sparse() const { return sparse_; }
  /// @name Places, with many contacts
  ///@{
  int first(int contact) const { return first_[contact]; }  ///< of its normal row; the tangential one follows
  int friction(int k) const { return friction_[k]; }        ///< of a friction element's row
  ///@}

  /// Computes the response to row(place); with many contacts once a step.
  void respond(SaddlePoint& saddle, int place);
  /// To row(place) + factor·`beside` (null: none), with its reactions where contacts are few.
  void respond(SaddlePoint& saddle, int place, const SparseRow* beside, double factor);
  /// `row` · A w of a place.
  double along(const SparseRow& row, int place) const;
  /// x += by A w
  void push(int place, double by, double* x) const;
  /// @name Of few contacts: A w, and the multipliers of the constraint rows with it
  ///@{
  double* response(int place) { return response_.data() + static_cast<long>(place) * n_; }
  const double* response(int place) const { return response_.data() + static_cast<long>(place) * n_; }
  double* reaction(int place) { return reaction_.data() + static_cast<long>(place) * m_; }
  const double* reaction(int place) const { return reaction_.data() + static_cast<long>(place) * m_; }
  ///@}

  /// @name Contacts without a number, behind the others
  ///@{
  void add_contact();
  /// Drops all behind the first `contacts`.
  void keep_contacts(int contacts);
  /// The rows of this contact are new.
  void renew(int contact);
  ///@}

 private:
  int n_, m_;
  bool many_;
  std::vector<SparseRow> rows_;
  std::vector<double> response_, reaction_;
  Responses sparse_;
  std::vector<char> taken_;  // responses of this step
  std::vector<int> first_, friction_;
};

}  // namespace freeplay
