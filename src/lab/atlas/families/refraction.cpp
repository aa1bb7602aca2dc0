#include "lab/atlas/families.h"

#include "exact/refraction.h"
#include "shade/fresnel.h"

namespace sightline {
namespace {

struct Boundary {
    float cos_i, eta;  ///< eta = n_transmitted / n_incident
};

/// Fresnel's reflectance from the cosine of refraction; 1 where its square is not positive.
template <class T>
T reflectance(T cos_i, T eta, T squared) {
    if (!(squared > T(0))) return T(1);
    const T cos_t = std::sqrt(squared);
    const T s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    const T p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return (s * s + p * p) / T(2);
}

/// The textbook: cos²t = 1 − (1 − cos²i)/eta².
template <class T>
double by_cosine(const Boundary& b) {
    const auto c = static_cast<T>(b.cos_i), n = static_cast<T>(b.eta);
    return static_cast<double>(reflectance(c, n, T(1) - (T(1) - c * c) / (n * n)));
}

/// The sine's square as (1 − c)(1 + c), compared with eta² by a product.
template <class T>
double by_product(const Boundary& b) {
    const auto c = static_cast<T>(b.cos_i), n = static_cast<T>(b.eta);
    return static_cast<double>(reflectance(c, n, ((n - T(1)) * (n + T(1)) + c * c) / (n * n)));
}

/// As materials compute it.
double as_rendered(const Boundary& b) {
    return static_cast<double>(fresnel_dielectric(b.cos_i, b.eta));
}

struct Formula {
    const char* name;
    double (*reflectance)(const Boundary&);
};
constexpr Formula formulas[] = {{"refract-rendered", as_rendered},
                                {"refract-cosine", by_cosine<float>},
                                {"refract-cosine-double", by_cosine<double>},
                                {"refract-product", by_product<float>},
                                {"refract-product-double", by_product<double>}};

/// The boundaries that differ by one ulp; cosines stay in [0, 1].
std::vector<ExactRefraction> neighbours(const Boundary& boundary) {
    std::vector<ExactRefraction> result;
    const auto numbers = [](Boundary& b) { return std::array{&b.cos_i, &b.eta}; };
    for (const auto& [cos_i, eta] : ulp_neighbours(boundary, numbers))
        result.push_back(exact_refraction(std::clamp(cos_i, 0.0f, 1.0f), eta));
    return result;
}

/// The most that one ulp of an input changes the reflectance.
double change_by_an_ulp(const Boundary& boundary, const ExactRefraction& truth) {
    double change = 0;
    for (const ExactRefraction& r : neighbours(boundary))
        change = std::max(change, std::abs(r.reflectance - truth.reflectance));
    return change;
}

bool is_decidable_boundary(const Boundary& boundary, const ExactRefraction& truth) {
    return std::ranges::all_of(neighbours(boundary),
                               [&](const ExactRefraction& r) { return r.total == truth.total; });
}

/// Close to the critical angle, the reflectance itself rounds to 1.
Verdict refraction_verdict(const Boundary& boundary, const ExactRefraction& truth,
                           const MethodAnswer& answer) {
    return hit_or_miss(answer, !truth.total, [&] {
        return (!truth.total && truth.reflectance > 1 - 0x1p-21) ||
               !is_decidable_boundary(boundary, truth);
    });
}

Measures refraction_measures(const Boundary& boundary, const ExactRefraction& truth,
                             const MethodAnswer& answer) {
    const double error = std::abs(answer.t - truth.reflectance);
    const auto rounded = static_cast<float>(truth.reflectance);
    const auto ulp = static_cast<double>(std::nextafter(rounded, INFINITY) - rounded);
    const double change = change_by_an_ulp(boundary, truth);
    return {.t_ulps = error / ulp, .stability = change > 0 ? 2 * error / change : not_measured};
}

/// Total reflection counts as a miss; t is the reflectance.
Problem<Boundary, ExactRefraction> refraction_problem() {
    std::vector<Method<Boundary>> methods;
    for (const Formula& formula : formulas)
        methods.push_back(case_method<Boundary>(formula.name, formula.reflectance,
                                                [](const Boundary&, double reflectance) {
                                                    return answer_of(reflectance < 1, reflectance);
                                                }));
    return {.methods = std::move(methods),
            .solve = [](const Boundary& b) { return exact_refraction(b.cos_i, b.eta); },
            .is_hit = [](const ExactRefraction& truth) { return !truth.total; },
            .is_decidable = is_decidable_boundary,
            .condition =
                [](const Boundary& b, const ExactRefraction& truth) {
                    return change_by_an_ulp(b, truth) / truth.reflectance * 0x1p23;
                },
            .measure = refraction_measures,
            .verdict = refraction_verdict};
}

/// cos²t = ±1/knob: just short of total reflection, or just beyond.
Boundary near_critical(double knob, Rng& rng) {
    const auto eta = static_cast<float>(1 / rng.uniform(1.05, 2.5));
    const double n = static_cast<double>(eta), squared = rng.sign() / knob;
    return {static_cast<float>(std::sqrt(std::clamp(1 - n * n * (1 - squared), 0.0, 1.0))), eta};
}

Boundary grazing_boundary(double knob, Rng& rng) {
    const auto eta = static_cast<float>(rng.uniform(1.05, 2.5));
    return {static_cast<float>(rng.uniform(0.5, 1) / knob), eta};
}

}  // namespace

std::vector<Family> refraction_families() {
    const auto problem = refraction_problem();
    return {
        random_family("R1", "refraction close to the critical angle",
                      "1 / squared cosine of refraction", powers(10, 0, 9), problem, near_critical),
        random_family("R2", "refraction at grazing incidence", "1 / cosine", powers(10, 0, 9),
                      problem, grazing_boundary)};
}

}  // namespace sightline
