// Functions of Python's as forces of a scene in memory.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "mechanism/own_force.hpp"
#include "mechanism/own_law.hpp"

namespace freeplay::python {

/// f(contact, penetration, rate, touch speed) in N; `what` tells it from any other. What it raises leaves the run.
std::shared_ptr<const OwnLaw> law_of(const pybind11::function& f, const std::string& name,
                                     const std::string& what);

/// f(t, place, velocity) gives two numbers in N; place and velocity are tuples of two.
std::shared_ptr<const OwnForce> force_of(const pybind11::function& f, const std::string& name,
                                         const std::string& what);

}  // namespace freeplay::python
