// The films of a mechanism at any state, for statistics (simulation/film_statistics.hpp).
#pragma once

#include <memory>

#include "simulation/film_statistics.hpp"

namespace freeplay {

struct Mechanism;

std::unique_ptr<FilmProbe> make_film_probe(const Mechanism& mechanism);

}  // namespace freeplay
