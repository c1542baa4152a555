// C text of a traced function. Only operations on which outputs and guards depend are written, in
// the order in which they were recorded. Long functions are divided into parts, because the time of
// a compiler grows faster than the length of a function; numbers that a later part needs are passed
// in an array.
#include <algorithm>
#include <map>

#include "numerics/trace.hpp"

namespace freeplay {
namespace {

constexpr int longest_part = 2000;  // operations

constexpr std::string_view head =
    "/* Written by Freeplay. Functions of one mechanism. */\n"
    "double sqrt(double); double fabs(double); double sin(double); double cos(double);\n"
    "double exp(double); double tanh(double); double atan2(double, double);\n";

constexpr std::string_view parameters = "const double *k, const double *const *in, double *const *out";

std::string number(int i) { return std::to_string(i); }

}  // namespace

std::string TracedObject::text() const {
  std::string text(head);
  text += functions_;
  text += "int (*const freeplay_functions[])(" + std::string(parameters) + ") = {";
  for (const auto& name : names_) text += name + ", ";
  text += "0};\nconst int freeplay_abi = 1;\n";
  return text;
}

std::string Trace::name_of(int node) const {
  const auto& n = nodes_[static_cast<std::size_t>(node)];
  if (n.operation != Operation::constant) return "x" + number(node);
  if (n.a < 0) return n.b < 0 ? "-1.0" : n.b > 0 ? "1.0" : "0.0";
  return "k[" + number(n.a) + "]";
}

std::string Trace::expression(const Node& n) const {
  const auto infix = [&](const char* sign) { return name_of(n.a) + sign + name_of(n.b); };
  const auto call = [&](const char* name) { return std::string(name) + "(" + name_of(n.a) + ")"; };
  switch (n.operation) {
    case Operation::input:
      return "in[" + number(n.a) + "][" + number(n.b) + "]";
    case Operation::add:
      return infix(" + ");
    case Operation::subtract:
      return infix(" - ");
    case Operation::multiply:
      return infix(" * ");
    case Operation::divide:
      return infix(" / ");
    case Operation::negate:
      return "-" + name_of(n.a);
    case Operation::sqrt:
      return call("sqrt");
    case Operation::abs:
      return call("fabs");
    case Operation::sin:
      return call("sin");
    case Operation::cos:
      return call("cos");
    case Operation::exp:
      return call("exp");
    case Operation::tanh:
      return call("tanh");
    case Operation::atan2:
      return "atan2(" + name_of(n.a) + ", " + name_of(n.b) + ")";
    case Operation::max:
      return name_of(n.a) + " < " + name_of(n.b) + " ? " + name_of(n.b) + " : " + name_of(n.a);
    default:
      return "";
  }
}

void Trace::write() {
  const auto size = nodes_.size();
  std::vector<bool> needed(size, false);
  for (const auto& o : outputs_) needed[o.node] = true;
  for (const auto& g : guards_) needed[g.a] = needed[g.b] = true;
  const auto operands = [&](std::size_t i, auto f) {
    const auto& n = nodes_[i];
    if (n.operation == Operation::constant || n.operation == Operation::input) return;
    f(n.a);
    if (n.b >= 0) f(n.b);
  };
  for (std::size_t i = size; i-- > 0;)
    if (needed[i]) operands(i, [&](int operand) { needed[operand] = true; });

  // The part of each node, and the last part that uses it. Constants belong to no part.
  std::vector<int> part(size, 0), last(size, 0);
  int count = 0;
  for (std::size_t i = 0; i < size; ++i) {
    if (!needed[i] || nodes_[i].operation == Operation::constant) continue;
    part[i] = last[i] = count++ / longest_part;
  }
  const int parts = count == 0 ? 1 : (count - 1) / longest_part + 1;
  const auto part_at = [&](int node) {  // the part in which the nodes before this one are known
    int p = 0;
    for (int i = 0; i < node; ++i)
      if (needed[i] && nodes_[i].operation != Operation::constant) p = part[i];
    return p;
  };
  std::vector<int> guard_part(guards_.size());
  const auto use = [&](int node, int by) { last[node] = std::max(last[node], by); };
  for (std::size_t i = 0; i < size; ++i)
    if (needed[i]) operands(i, [&](int operand) { use(operand, part[i]); });
  for (std::size_t g = 0; g < guards_.size(); ++g) {
    guard_part[g] = parts == 1 ? 0 : part_at(guards_[g].after);
    use(guards_[g].a, guard_part[g]);
    use(guards_[g].b, guard_part[g]);
  }
  for (const auto& o : outputs_) use(o.node, parts - 1);
  const auto passed = [&](std::size_t i) {
    return needed[i] && nodes_[i].operation != Operation::constant && last[i] > part[i];
  };
  std::vector<int> place(size, -1);
  int places = 0;
  for (std::size_t i = 0; i < size; ++i)
    if (passed(i)) place[i] = places++;

  auto& text = object_.functions_;
  std::size_t g = 0;
  for (int p = 0; p < parts; ++p) {
    if (parts == 1)
      text += "static int " + name_ + "(" + std::string(parameters) + ") {\n";
    else
      text += "static int " + name_ + "_" + number(p) + "(" + std::string(parameters) + ", double *w) {\n";
    for (std::size_t i = 0; i < size; ++i)
      if (passed(i) && part[i] < p && last[i] >= p)
        text += "const double x" + number(static_cast<int>(i)) + " = w[" + number(place[i]) + "];\n";
    const auto guards_until = [&](int node) {
      for (; g < guards_.size() && guard_part[g] == p && guards_[g].after <= node; ++g) {
        const auto& x = guards_[g];
        const char* sign = x.relation == Relation::less         ? " < "
                           : x.relation == Relation::less_equal ? " <= "
                                                                : " == ";
        text += std::string("if (") + (x.result ? "!" : "") + "(" + name_of(x.a) + sign + name_of(x.b) +
                ")) return 1;\n";
      }
    };
    for (std::size_t i = 0; i < size; ++i) {
      const int node = static_cast<int>(i);
      if (!needed[i] || nodes_[i].operation == Operation::constant || part[i] != p) continue;
      guards_until(node);
      text += "const double x" + number(node) + " = " + expression(nodes_[i]) + ";\n";
      if (passed(i)) text += "w[" + number(place[i]) + "] = x" + number(node) + ";\n";
    }
    guards_until(static_cast<int>(size));
    if (p == parts - 1)
      for (const auto& o : outputs_)
        text += "out[" + number(o.array) + "][" + number(o.index) + "] = " + name_of(o.node) + ";\n";
    text += "return 0;\n}\n";
  }
  if (parts > 1) {
    text += "static int " + name_ + "(" + std::string(parameters) + ") {\ndouble w[" +
            number(std::max(places, 1)) + "];\n";
    for (int p = 0; p < parts; ++p) text += "if (" + name_ + "_" + number(p) + "(k, in, out, w)) return 1;\n";
    text += "return 0;\n}\n";
  }
  object_.names_.push_back(name_);
  object_.operations_ += count;
}

}  // namespace freeplay
