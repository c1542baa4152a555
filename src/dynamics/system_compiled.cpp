// Calls of the compiled functions of a System (system_functions.hpp).
#include <algorithm>
#include <utility>

#include "dynamics/system.hpp"
#include "dynamics/system_functions.hpp"

namespace freeplay {

void System::attach(SystemFunctions functions) {
  *functions_ = std::move(functions);
  functions_->solve.constants = functions_->constants.data();
  compiled_ = functions_->object != nullptr;
  compiled_contacts_ = compiled_ && !functions_->contacts.empty();
}

const SolveFunctions* System::solve_functions() const { return &functions_->solve; }

long System::refused() const { return functions_->refused; }

bool System::place_compiled(double t, const double* q, Evaluation& e) const {
  const auto* pieces = functions_->place_reads_pieces ? e.pieces : nullptr;
  const auto function = pieces ? functions_->place_in_pieces : functions_->place;
  if (!function) return false;
  const double* in[] = {&t, q, pieces ? &pieces->low : nullptr};
  double* out[] = {e.cosine.data(), e.sine.data(), e.phi.data(), e.phi_t.data(), e.G.data(), e.bend.data()};
  if (function(functions_->constants.data(), in, out) == 0) return true;
  ++functions_->refused;
  return false;
}

bool System::rate_compiled(const double* q, const double* v, Evaluation& e) const {
  if (!functions_->rate) return false;
  const double* in[] = {q, v, e.cosine.data(), e.sine.data(), e.bend.data()};
  double* out[] = {e.gamma.data()};
  if (functions_->rate(functions_->constants.data(), in, out) == 0) return true;
  ++functions_->refused;
  return false;
}

bool System::forces_compiled(double t, const double* q, const double* v, const double* z, Evaluation& e,
                             const Reading& reading) const {
  static_assert(sizeof(Piece) == 2 * sizeof(double));
  const auto& f = *functions_;
  const auto* pieces = f.reads_pieces ? reading.pieces : nullptr;
  const auto* sweep = f.reads_steps ? reading.sweep : nullptr;
  const auto function = pieces ? f.forces_in_pieces : sweep ? f.forces_over_step : f.forces;
  if (!function || !v || (!z && states() > 0)) return false;
  const double* in[] = {&t, q, v, z, e.cosine.data(), e.sine.data(), nullptr, nullptr, nullptr};
  if (pieces) {
    in[6] = &pieces->low;
  } else if (sweep) {
    in[6] = &sweep->h;
    in[7] = sweep->start;
    in[8] = sweep->mean;
  }
  double* out[] = {e.force.data(), &e.power.drive, &e.power.load, &e.power.damping};
  if (function(f.constants.data(), in, out) == 0) return true;
  ++functions_->refused;
  return false;
}

bool System::contact_compiled(int k, const double* q, const double* v, const Evaluation& e,
                              ContactRow& row) const {
  const auto& contact = functions_->contacts[static_cast<std::size_t>(k)];
  if (!contact.function) return false;
  const double* in[] = {q, v, e.cosine.data(), e.sine.data()};
  double* out[] = {&row.gap,
                   row.normal.value.data(),
                   row.tangent.value.data(),
                   row.film.value.data(),
                   &row.gamma_n,
                   &row.gamma_t,
                   &row.gamma_film,
                   &row.turn};
  if (contact.function(functions_->constants.data(), in, out) != 0) {
    ++functions_->refused;
    return false;
  }
  const auto shape = [](SparseRow& to, const SparseRow& from) {
    to.size = from.size;
    to.column = from.column;
  };
  shape(row.normal, contact.pattern.normal);
  shape(row.tangent, contact.pattern.tangent);
  row.film.size = row.spin.size = 0;
  if (contact.pattern.film.size > 0) {
    shape(row.film, contact.pattern.film);
    row.spin = contact.pattern.spin;  // its values are constant
  }
  return true;
}

}  // namespace freeplay
