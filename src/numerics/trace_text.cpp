// C text of a traced function. Only operations on which outputs and guards depend are written, in
// the order in which they were recorded. Long functions are divided into parts, because the time of
// a compiler grows faster than the length of a function; numbers that a later part needs are passed
// in an array.
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "numerics/trace.hpp"

namespace freeplay {
namespace {

constexpr int longest_part = 2000;  // operations

constexpr std::string_view head =
    "/* Written by Freeplay. Functions of one mechanism. */\n"
    "double sqrt(double); double fabs(double); double sin(double); double cos(double);\n"
    "double exp(double); double tanh(double); double atan2(double, double);\n"
    "double floor(double); double round(double);\n";

/// std::upper_bound among n numbers.
constexpr std::string_view search =
    "static int locate(const double *k, int n, double x) {\nint i = 0;\n"
    "while (n > 0) {\nconst int half = n / 2;\n"
    "if (x < k[i + half]) n = half; else { i += half + 1; n -= half + 1; }\n}\nreturn i;\n}\n";

std::string number(int i) { return std::to_string(i); }

std::string parameters(int lanes) {
  const std::string type = lanes > 0 ? "lanes" : "double";
  return "const " + type + " *k, const " + type + " *const *in, " + type + " *const *out";
}

/// Joins f(lane) of all lanes.
std::string of_each(int lanes, const char* between, auto f) {
  std::string list;
  for (int i = 0; i < lanes; ++i) list += (i > 0 ? between : "") + std::string(f("[" + number(i) + "]"));
  return list;
}

/// Types and functions of lanes. Functions of the math library are called for each lane. A square root
/// is rounded correctly, alone and in lanes.
std::string head_of_lanes(int lanes) {
  const auto size = "__attribute__((vector_size(" + number(8 * lanes) + ")));\n";
  std::string text = "typedef double lanes " + size + "typedef long long marks " + size;
  const auto value = [&](const char* x) {
    return "{" + of_each(lanes, ", ", [&](const auto&) { return x; }) + "};\n";
  };
  text += std::string("static const lanes l0 = ") + value("0.0") + "static const lanes l1 = " + value("1.0") +
          "static const lanes lm = " + value("-1.0");
  text +=
      "static inline lanes select(marks m, lanes a, lanes b) {\n"
      "return (lanes)((m & (marks)a) | (~m & (marks)b));\n}\n"
      "static inline lanes fabs_l(lanes x) { return (lanes)((marks)x & 0x7fffffffffffffffLL); }\n";
  const auto function = [&](const std::string& name, bool two) {
    text += "static inline lanes " + name + "_l(lanes x" + (two ? ", lanes y" : "") + ") {\nreturn (lanes){" +
            of_each(lanes, ", ",
                    [&](const auto& at) { return name + "(x" + at + (two ? ", y" + at : "") + ")"; }) +
            "};\n}\n";
  };
  for (const char* name : {"sin", "cos", "exp", "tanh", "floor", "round"}) function(name, false);
  function("atan2", true);
  const char* root = lanes == 8 ? "__AVX512F__" : lanes == 4 ? "__AVX__" : nullptr;
  if (root)
    text += std::string("#ifdef ") + root + "\nstatic inline lanes sqrt_l(lanes x) { return " +
            (lanes == 8 ? "__builtin_ia32_sqrtpd512_mask(x, x, -1, 4)" : "__builtin_ia32_sqrtpd256(x)") +
            "; }\n#else\n";
  function("sqrt", false);
  if (root) text += "#endif\n";
  text += "static inline int bits(marks m) {\nreturn ";
  for (int i = 0; i < lanes; ++i)
    text += (i > 0 ? " | " : "") + ("(int)(m[" + number(i) + "] & " + number(1 << i) + ")");
  return text + ";\n}\n";
}

/// Look-ups of lanes, of which each has its own table.
std::string look_ups_of_lanes(int lanes) {
  std::string text = "static int locate(const lanes *k, int n, double x, int lane) {\nint i = 0;\n";
  text += "while (n > 0) {\nconst int half = n / 2;\n";
  text += "if (x < k[i + half][lane]) n = half; else { i += half + 1; n -= half + 1; }\n}\nreturn i;\n}\n";
  text += "static inline marks locate_l(const lanes *k, int n, lanes x) {\nreturn (marks){";
  for (int i = 0; i < lanes; ++i) {
    if (i > 0) text += ", ";
    text += "locate(k, n, x[" + number(i) + "], " + number(i) + ")";
  }
  text += "};\n}\nstatic inline lanes pick_l(const lanes *k, marks i) {\nreturn (lanes){";
  text += of_each(lanes, ", ", [&](const auto& at) { return "k[i" + at + "]" + at; });
  text += "};\n}\n";
  return text;
}

/// The text of one function.
class FunctionText {
 public:
  FunctionText(const TracedFunction& f, int lanes)
      : name_(f.name),
        nodes_(f.nodes),
        guards_(f.guards),
        outputs_(f.outputs),
        uses_(f.uses()),
        lanes_(lanes) {}
  /// Appends it.
  void append(std::string& text) const;

 private:
  using Node = TracedFunction::Node;
  using Guard = TracedFunction::Guard;
  std::string name_of(int node) const;
  std::string expression(const Node& node) const;
  std::string failing(const Guard& x) const;
  bool is_whole(int node) const;

  const std::string& name_;
  const std::vector<Node>& nodes_;
  const std::vector<Guard>& guards_;
  const std::vector<TracedFunction::Output>& outputs_;
  const std::vector<int> uses_;
  int lanes_;
};

std::string FunctionText::name_of(int node) const {
  const auto& n = nodes_[static_cast<std::size_t>(node)];
  if (n.operation != Operation::constant) return "x" + number(node);
  if (n.a < 0) {
    if (lanes_ > 0) return n.b < 0 ? "lm" : n.b > 0 ? "l1" : "l0";
    return n.b < 0 ? "-1.0" : n.b > 0 ? "1.0" : "0.0";
  }
  return "k[" + number(n.a) + "]";
}

std::string FunctionText::expression(const Node& n) const {
  const auto infix = [&](const char* sign) { return name_of(n.a) + sign + name_of(n.b); };
  const bool lanes = lanes_ > 0;
  const auto call = [&](const char* name) {
    return name + std::string(lanes ? "_l(" : "(") + name_of(n.a) + (n.b < 0 ? "" : ", " + name_of(n.b)) +
           ")";
  };
  const auto choice = [&](const std::string& condition, int a, int b) {
    return lanes ? "select(" + condition + ", " + name_of(a) + ", " + name_of(b) + ")"
                 : condition + " ? " + name_of(a) + " : " + name_of(b);
  };
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
    case Operation::floor:
      return call("floor");
    case Operation::round:
      return call("round");
    case Operation::atan2:
      return call("atan2");
    case Operation::max:
      return choice(infix(" < "), n.b, n.a);
    case Operation::less:
      return infix(" < ");
    case Operation::less_equal:
      return infix(" <= ");
    case Operation::equal:
      return infix(" == ");
    case Operation::both:
      return infix(" & ");
    case Operation::either:
      return infix(" | ");
    case Operation::select:
      return choice(name_of(n.a), n.b, n.c);
    case Operation::locate:
      return std::string(lanes ? "locate_l" : "locate") + "(k + " + number(n.b) + ", " + number(n.c) + ", " +
             name_of(n.a) + ")";
    case Operation::pick:
      return lanes ? "pick_l(k + " + number(n.b) + ", " + name_of(n.a) + ")"
                   : "k[" + number(n.b) + " + " + name_of(n.a) + "]";
    default:
      return "";
  }
}

/// Whether a node is a condition or an index.
bool FunctionText::is_whole(int node) const {
  const auto operation = nodes_[static_cast<std::size_t>(node)].operation;
  return (operation >= Operation::less && operation <= Operation::either) || operation == Operation::locate;
}

/// The condition under which a guard fails.
std::string FunctionText::failing(const Guard& x) const {
  const char* no = lanes_ > 0 ? "~" : "!";
  if (x.b < 0) return no + name_of(x.a);
  const char* sign = x.relation == Relation::less         ? " < "
                     : x.relation == Relation::less_equal ? " <= "
                                                          : " == ";
  return std::string(x.result ? no : "") + "(" + name_of(x.a) + sign + name_of(x.b) + ")";
}

void FunctionText::append(std::string& text) const {
  const int lanes = lanes_;
  const std::string type = lanes > 0 ? "lanes" : "double";
  const char* end = lanes > 0 ? "return bits(bad);\n}\n" : "return 0;\n}\n";
  const auto size = nodes_.size();

  // The part of each node, and the last part that uses it. Constants belong to no part.
  std::vector<int> part(size, 0), last(size, 0);
  int count = 0;
  for (std::size_t i = 0; i < size; ++i) {
    if (uses_[i] == 0 || nodes_[i].operation == Operation::constant) continue;
    part[i] = last[i] = count++ / longest_part;
  }
  const int parts = count == 0 ? 1 : (count - 1) / longest_part + 1;
  const auto part_at = [&](int node) {  // the part in which the nodes before this one are known
    int p = 0;
    for (int i = 0; i < node; ++i)
      if (uses_[i] > 0 && nodes_[i].operation != Operation::constant) p = part[i];
    return p;
  };
  std::vector<int> guard_part(guards_.size());
  const auto use = [&](int node, int by) { last[node] = std::max(last[node], by); };
  for (std::size_t i = 0; i < size; ++i)
    if (uses_[i] > 0) nodes_[i].each_operand([&](int operand) { use(operand, part[i]); });
  for (std::size_t g = 0; g < guards_.size(); ++g) {
    guard_part[g] = parts == 1 ? 0 : part_at(guards_[g].after);
    use(guards_[g].a, guard_part[g]);
    if (guards_[g].b >= 0) use(guards_[g].b, guard_part[g]);
  }
  for (const auto& o : outputs_) use(o.node, parts - 1);
  const auto define = [&](int node, const std::string& value, bool stored) {
    const std::string kind = !is_whole(node) ? type : lanes > 0 ? "marks" : "int";
    return "const " + kind + " x" + number(node) + " = " + (stored && lanes > 0 ? "(" + kind + ")" : "") +
           value + ";\n";
  };
  const auto passed = [&](std::size_t i) {
    return uses_[i] > 0 && nodes_[i].operation != Operation::constant && last[i] > part[i];
  };
  std::vector<int> place(size, -1);
  int places = 0;
  for (std::size_t i = 0; i < size; ++i)
    if (passed(i)) place[i] = places++;

  std::size_t g = 0;
  for (int p = 0; p < parts; ++p) {
    if (parts == 1)
      text += "static int " + name_ + "(" + parameters(lanes) + ") {\n";
    else
      text += "static int " + name_ + "_" + number(p) + "(" + parameters(lanes) + ", " + type + " *w) {\n";
    if (lanes > 0) text += "marks bad = {0};\n";
    for (std::size_t i = 0; i < size; ++i)
      if (passed(i) && part[i] < p && last[i] >= p)
        text += define(static_cast<int>(i), "w[" + number(place[i]) + "]", true);
    const auto guards_until = [&](int node) {
      for (; g < guards_.size() && guard_part[g] == p && guards_[g].after <= node; ++g) {
        const auto fails = failing(guards_[g]);
        text += lanes > 0 ? "bad |= " + fails + ";\n" : "if (" + fails + ") return 1;\n";
      }
    };
    for (std::size_t i = 0; i < size; ++i) {
      const int node = static_cast<int>(i);
      if (uses_[i] == 0 || nodes_[i].operation == Operation::constant || part[i] != p) continue;
      guards_until(node);
      text += define(node, expression(nodes_[i]), false);
      if (passed(i))
        text += "w[" + number(place[i]) + "] = " + (lanes > 0 ? "(lanes)x" : "x") + number(node) + ";\n";
    }
    guards_until(static_cast<int>(size));
    if (p == parts - 1)
      for (const auto& o : outputs_)
        text += "out[" + number(o.array) + "][" + number(o.index) + "] = " + name_of(o.node) + ";\n";
    text += end;
  }
  if (parts > 1) {
    text += "static int " + name_ + "(" + parameters(lanes) + ") {\n" + type + " w[" +
            number(std::max(places, 1)) + "];\n" + (lanes > 0 ? "int failed = 0;\n" : "");
    for (int p = 0; p < parts; ++p) {
      const auto call = name_ + "_" + number(p) + "(k, in, out, w)";
      text += lanes > 0 ? "failed |= " + call + ";\n" : "if (" + call + ") return 1;\n";
    }
    text += lanes > 0 ? "return failed;\n}\n" : "return 0;\n}\n";
  }
}

}  // namespace

/// One lane is a plain number.
std::string TracedObject::text() const {
  const int wide = lanes_ > 1 ? lanes_ : 0;
  std::string text(head);
  if (wide > 0) text += head_of_lanes(wide);
  if (!tables_.empty()) text += wide > 0 ? look_ups_of_lanes(wide) : std::string(search);
  for (const auto& f : functions_) FunctionText(*f, wide).append(text);
  text += "int (*const freeplay_functions[])(" + parameters(wide) + ") = {";
  for (const auto& f : functions_) text += f->name + ", ";
  text += "0};\nconst int freeplay_abi = 1;\n";
  return text;
}

}  // namespace freeplay
