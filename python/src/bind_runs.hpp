// Python functions as user-defined forces of a scene in memory.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "mechanism/outside.hpp"

namespace freeplay::python {

/// Contact law from f(contact, penetration, rate, speed at contact onset), which returns N. `what`
/// is the text that identifies the function. Exceptions of f propagate out of the run.
std::shared_ptr<const OwnLaw> law_of(const pybind11::function& f, const std::string& name,
                                     const std::string& what);

/// Force from f(t, place, velocity), which returns two numbers in N; place and velocity are tuples
/// of two.
std::shared_ptr<const OwnForce> force_of(const pybind11::function& f, const std::string& name,
                                         const std::string& what);

}  // namespace freeplay::python
