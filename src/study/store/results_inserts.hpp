// The statements that store a run, prepared once.
#pragma once

#include "study/store/results.hpp"

namespace freeplay {

class Results::Inserts {
 public:
  Inserts(const Database& owner, std::size_t columns_of_runs);

  const Database& database;
  Database::Statement run, turn, flight, impact, measure, cost, spectrum, trace, done;
};

}  // namespace freeplay
