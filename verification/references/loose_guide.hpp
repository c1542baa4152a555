// A slider-crank with clearance in its guide (Flores, Leine, Glocker 2010, with variants): tables of
// its impacts, and its free flight by two coordinates.
//
// The impacts are those of an independent event-driven program in minimal coordinates, which shares
// no code, language or integrator with Freeplay. Runs at two tolerances agree to the printed digits.
// Corners are named as in Freeplay; impulses and rates are as in events.csv.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

struct CornerImpact {
  double t;  // s
  const char* corner;
  double v_n_minus, v_n_plus, v_t_minus, v_t_plus;  // m/s
  double impulse_n, impulse_t;                      // N s
};

struct GuideTable {
  double slider_speed;  // rad/s, angular velocity of the slider at the start
  double friction, e_T;
  std::vector<CornerImpact> impacts;
};

/// Friction 0.3, where all impacts slip, so that e_T has no effect.
inline const std::vector<CornerImpact> slipping_impacts = {
    {0.002255614616571, "front_upper", -0.8509440595, 0.3403776238, -7.869836457, -7.269875507,
     0.001113168235, 0.0003339504705},
    {0.002634109730122, "rear_upper", -1.845866456, 0.7383465822, -7.817049129, -9.095317234, 0.00324615532,
     0.0009738465959},
    {0.002680083566202, "front_upper", -2.311299668, 0.9245198672, -9.151452278, -7.547017009, 0.003010573568,
     0.0009031720704},
    {0.002693808825214, "rear_upper", -2.453433865, 0.9813735459, -7.564138246, -9.259127081, 0.004308929242,
     0.001292678773},
    {0.002699026970469, "front_upper", -2.427565212, 0.9710260849, -9.265334906, -7.581361591, 0.003161417607,
     0.0009484252821},
    {0.00270120053656, "rear_upper", -2.354618116, 0.9418472463, -7.584044695, -9.210328068, 0.00413476335,
     0.001240429005}};

inline const std::vector<GuideTable> guide_tables = {
    {0,
     0.01,
     0,
     {{0.002692502752021, "rear_upper", -0.841612322, 0.3366449288, -8.407508187, -8.54655447, 0.05574032307,
       0.0005574032307},
      {0.002692502752021, "front_upper", -0.841612322, 0.3366449288, -8.407508187, -8.54655447, 0.05518569299,
       0.0005518569299},
      {0.00561236319021, "rear_upper", -0.2478256463, 0.09913025852, -10.36466641, -10.40328923,
       0.01667721707, 0.0001667721707},
      {0.00561236319021, "front_upper", -0.2478256463, 0.09913025852, -10.36466641, -10.40328923,
       0.01651127461, 0.0001651127461},
      {0.007475056212396, "rear_upper", -0.08420428243, 0.03368171297, -10.78157525, -10.79419243,
       0.005696792034, 5.696792034e-05},
      {0.007475056212396, "front_upper", -0.08420428243, 0.03368171297, -10.78157525, -10.79419243,
       0.005640107536, 5.640107536e-05},
      {0.008421767934249, "rear_upper", -0.03114313389, 0.01245725356, -10.90626166, -10.91087793,
       0.002111680766, 2.111680766e-05},
      {0.008421767934249, "front_upper", -0.03114313389, 0.01245725356, -10.90626166, -10.91087793,
       0.002090669017, 2.090669017e-05}}},
    {3,
     0.01,
     0,
     {{0.002255614616571, "front_upper", -0.8509440595, 0.3403776238, -7.869836457, -7.272551715,
       0.00127418178, 1.27418178e-05},
      {0.002634981483695, "rear_upper", -1.841913782, 0.736765513, -7.821024037, -9.102499889, 0.002769996072,
       2.769996072e-05},
      {0.002680984216964, "front_upper", -2.313784363, 0.9255137452, -9.158710782, -7.560318939,
       0.003442876374, 3.442876374e-05},
      {0.00269472393277, "rear_upper", -2.447068506, 0.9788274024, -7.577488308, -9.276056502, 0.003676644337,
       3.676644337e-05},
      {0.0026999525387, "front_upper", -2.427857773, 0.9711431093, -9.282296979, -7.606289501, 0.003611617375,
       3.611617375e-05},
      {0.002702133121619, "rear_upper", -2.345633758, 0.9382535033, -7.608992572, -9.236726301, 0.00352387122,
       3.52387122e-05}}},
    {3, 0.3, 0, slipping_impacts},
    {3, 0.3, 0.3, slipping_impacts},
    {30,
     1,
     0.3,
     {{0.0006549159151807, "front_upper", -1.587630323, 0.6350521291, -3.98994406, -2.831915254,
       0.001594520352, 0.001594520352},
      {0.002381185847725, "rear_upper", -1.454105623, 0.5816422491, -7.619681274, -8.61649102, 0.004392933177,
       0.004392933177},
      {0.002656315205642, "front_upper", -2.043473359, 0.8173893437, -8.984745008, -7.551076123,
       0.002046578117, 0.002046578117},
      {0.002719895984183, "rear_upper", -2.344883765, 0.9379535058, -7.629855861, -9.214682047,
       0.006963168853, 0.006963168853},
      {0.002741705702329, "front_upper", -2.360358552, 0.9441434209, -9.239817627, -7.588788482,
       0.002363453428, 0.002363453428},
      {0.002750457987855, "rear_upper", -2.331219033, 0.9324876133, -7.599160996, -9.172825048,
       0.006912385765, 0.006912385765}}},
};

/// verification/scenes/free_slider.toml: μ = 0.8, e_T = 0.3; most of these impacts stick,
/// v_T⁺ = −e_T v_T⁻.
inline const std::vector<CornerImpact> free_slider_impacts = {
    {0.001026061254834, "front_upper", -0.9697766109, 0.5818659666, 0.4663281943, 0.409230467, 0.04910239045,
     -0.03928191236},
    {0.002004976834412, "rear_upper", -0.6229163937, 0.3737498362, 0.4041851491, -0.1212555447, 0.01862895624,
     -0.01096260757},
    {0.007063442810591, "rear_lower", -0.4164893503, 0.2498936102, 0.001423841428, -0.0004271524284,
     0.02056824173, 0.0152358087},
    {0.01040827950865, "front_lower", -0.2807492195, 0.1684495317, -0.01657441943, 0.004972325828,
     0.01337641004, -0.008950145699},
    {0.04505761060198, "rear_lower", -0.1699552827, 0.1019731696, -0.1649941299, -0.1549439902,
     0.008622214888, 0.00689777191},
    {0.04898653791833, "front_lower", -0.2046014462, 0.1227608677, -0.1736645972, 0.01380103581,
     0.005756804763, 0.00460544381},
    {0.05181005892747, "rear_lower", -0.1309954781, 0.07859728685, -7.50458717e-05, 2.251376151e-05,
     0.00642886721, 0.00479476749},
    {0.06967506245269, "front_lower", -0.09341485814, 0.05604891488, -0.08757854423, -0.002408347928,
     0.002626696173, 0.002101356938}};

/// One impact by three laws. Newton by enumeration of all cases, the energetic law by exact
/// integration along the normal impulse and again by small steps; the same independent program.
/// Poisson by poisson_impacts.py, where friction changes its sign; elsewhere by enumeration of all
/// cases in each phase. Only cases
/// with one solution.
struct SingleImpact {
  double mu, e, v_t_minus, v_n_minus, D_nn, D_nt, D_tt;
  double newton[2], poisson[2], energetic[2];  // N s: P_N, P_T
};
inline const std::vector<SingleImpact> single_impacts = {
    {0.1, 0.5, 1, -1, 2.5, 1.5, 2.5, 0.63829787234043, -0.063829787234043, 0.63829787234043,
     -0.063829787234043, 0.63829787234043, -0.063829787234043},
    {0.1, 0.5, -1, -1, 2.5, 1.5, 2.5, 0.56603773584906, 0.056603773584906, 0.56603773584906,
     0.056603773584906, 0.56603773584906, 0.056603773584906},
    {0.3, 0.7, 0.4, -1, 2.5, 1.5, 2.5, 0.82926829268293, -0.24878048780488, 0.82926829268293,
     -0.24878048780488, 0.82926829268293, -0.24878048780488},
    {0.3, 0.7, -0.4, -1, 2.5, 1.5, 2.5, 0.82926829268293, -0.24878048780488, 0.69658536585366,
     -0.10230894308943, 0.70820198065953, -0.10579392753119},
    {1, 0.8, -0.3, -1, 1.75, 1.299038105676658, 3.25, 1.3650721420742, -0.4533171475545, 1.2871298557337,
     -0.42216330140065, 1.2907127752446, -0.42359540877735},
    {1, 0.8, 0.3, -1, 1.75, 1.299038105676658, 3.25, 1.5599278579257, -0.7158171475545, 1.6378701442663,
     -0.74697099370834, 1.6312542785602, -0.74432660550699},
    {0.2, 0.6, -0.5, -1, 1.75, 1.299038105676658, 3.25, 1.0736868760656, -0.21473737521312, 0.93056395183834,
     -0.083498070102584, 0.94220652245654, -0.085826584226224},
    {0.2, 0.6, -1.5, -1, 1.75, 1.299038105676658, 3.25, 0.81286071037125, 0.13663475772934, 0.79609609555375,
     0.1486249416845, 0.79640685861695, 0.14856278907186},
    {0.1, 0.9, -0.2, -1, 1.200961894323342, 0.75, 3.799038105676658, 1.6874460934949, -0.16874460934949,
     1.6426428258792, -0.12886303902551, 1.6448123403276, -0.12907999047035},
    {0.5, 0.5, -1, -1, 3.25, 1.299038105676658, 1.75, 0.3846628211518, 0.1923314105759, 0.3846628211518,
     0.1923314105759, 0.3846628211518, 0.1923314105759},
    {0.5, 0.5, 1, -1, 3.25, 1.299038105676658, 1.75, 0.57681637761553, -0.28840818880777, 0.57681637761553,
     -0.28840818880777, 0.57681637761553, -0.28840818880777},
    {0.9, 0.8, 0.5, -0.5, 3.25, 1.299038105676658, 1.75, 0.43251229422667, -0.389261064804, 0.43251229422667,
     -0.389261064804, 0.43251229422667, -0.389261064804},
    {2.2, 0.5, 2, -0.5, 1.75, 1.299038105676658, 3.25, 1.2588940528383, -1.1185696448144, 1.5836535792575,
     -1.2483773371221, 1.5281637509579, -1.2261978289871},
    {2.5, 0.8, 3, -0.2, 1.535818585470191, 1.149066664678467, 3.464181414529809, 1.1735763258165,
     -1.2552799389237, 1.8630163246236, -1.483966726689, 1.7171451736967, -1.4355813632189},
    {1.9, 1, 0.8, -1, 1.75, 1.299038105676658, 3.25, 1.8848076211353, -0.99951905283833, 2.1446152422707,
     -1.1033652066845, 2.1245513896059, -1.0953456038666},
    {0.3, 0.5, 1, -1, 1, 1.83697019872103e-16, 4, 1.5, -0.25, 1.5, -0.25, 1.5, -0.25}};

// Free flight of the slider-crank with clearance in the slider's guide (Flores, Leine, Glocker
// 2010), in two coordinates derived by hand. The crank (angle a) is free; the slider turns about a
// pin at its own centre, so it acts on the bars only as a mass at the rod's end. A double pendulum,
// u(a) = (cos a, sin a):
//
//     centres     l₁ u(a)/2,     l₁ u(a) + l₂ u(b)/2,     l₁ u(a) + l₂ u(b)
//     k = (m₂/2 + m₃) l₁ l₂,     M₁ = J₁ + (m₁/4 + m₂ + m₃) l₁²,     M₂ = J₂ + (m₂/4 + m₃) l₂²
//     M₁ ä + k cos(a − b) b̈ = −k sin(a − b) ḃ² − g (m₁/2 + m₂ + m₃) l₁ cos a
//     k cos(a − b) ä + M₂ b̈ =  k sin(a − b) ȧ² − g (m₂/2 + m₃) l₂ cos b
//
// Valid until a corner is in contact, |l₁ sin a + l₂ sin b| < c for a slider that does not turn.
// Sign convention: angles counter-clockwise from the guide's axis. Units: m, kg, s, rad.
// Source: Lagrange's equations; data of the paper, Multibody Syst. Dyn. 23 (2010) 165.

struct LooseGuide {
  long double l1 = 0.153L, l2 = 0.306L;               ///< m
  long double m1 = 0.038L, m2 = 0.038L, m3 = 0.076L;  ///< kg
  long double J1 = 7.4e-5L, J2 = 5.9e-4L, g = 9.81L;  ///< kg m², m/s²
  long double clearance = 1e-3L;                      ///< m, half the total clearance
};

using GuideState = std::array<long double, 4>;  ///< a, b, ȧ, ḃ
inline constexpr GuideState guide_start{0, 0, 150, -75};

inline GuideState guide_rates(const LooseGuide& m, const GuideState& y) {
  const long double k = (m.m2 / 2 + m.m3) * m.l1 * m.l2, c = std::cos(y[0] - y[1]), s = std::sin(y[0] - y[1]);
  const long double M1 = m.J1 + (m.m1 / 4 + m.m2 + m.m3) * m.l1 * m.l1;
  const long double M2 = m.J2 + (m.m2 / 4 + m.m3) * m.l2 * m.l2;
  const long double f1 = -k * s * y[3] * y[3] - m.g * (m.m1 / 2 + m.m2 + m.m3) * m.l1 * std::cos(y[0]);
  const long double f2 = k * s * y[2] * y[2] - m.g * (m.m2 / 2 + m.m3) * m.l2 * std::cos(y[1]);
  const long double det = M1 * M2 - k * c * k * c;
  return {y[2], y[3], (M2 * f1 - k * c * f2) / det, (M1 * f2 - k * c * f1) / det};
}

/// Kinetic and potential energy (J) by the three centres of mass, not by M₁, M₂ and k.
inline long double guide_energy(const LooseGuide& m, const GuideState& y) {
  const auto point = [&](long double along1, long double along2) {  // speed² and height
    const long double vx = -along1 * y[2] * std::sin(y[0]) - along2 * y[3] * std::sin(y[1]);
    const long double vy = along1 * y[2] * std::cos(y[0]) + along2 * y[3] * std::cos(y[1]);
    return std::array{vx * vx + vy * vy, along1 * std::sin(y[0]) + along2 * std::sin(y[1])};
  };
  const auto [v1, h1] = point(m.l1 / 2, 0);
  const auto [v2, h2] = point(m.l1, m.l2 / 2);
  const auto [v3, h3] = point(m.l1, m.l2);
  return (m.m1 * v1 + m.m2 * v2 + m.m3 * v3 + m.J1 * y[2] * y[2] + m.J2 * y[3] * y[3]) / 2 +
         m.g * (m.m1 * h1 + m.m2 * h2 + m.m3 * h3);
}

/// The state at the time t (s) before any contact, by equal steps of order 8.
inline GuideState guide_flight(const LooseGuide& m, long double t, int steps = 200) {
  const CooperVerner<long double> method;
  const long double h = t / steps;
  GuideState y = guide_start;
  for (int i = 0; i < steps; ++i)
    y = method.step([&](long double, const GuideState& at) { return guide_rates(m, at); }, i * h, y, h);
  return y;
}

/// Height of the slider's centre relative to the clearance.
inline long double guide_height(const LooseGuide& m, const GuideState& y) {
  return (m.l1 * std::sin(y[0]) + m.l2 * std::sin(y[1])) / m.clearance;
}

}  // namespace freeplay::reference
