// Refraction: a cosine and an index, and whether light gets through.
#include "exact/refraction.h"
#include "lab/atlas/dice.h"
#include "lab/atlas/families.h"
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

/// Total reflection is the miss; t is the reflectance.
class RefractionTrial : public Trial {
  public:
    explicit RefractionTrial(std::vector<Boundary> boundaries)
        : boundaries_(std::move(boundaries)) {
        for (const Boundary& b : boundaries_) truths_.push_back(exact_refraction(b.cos_i, b.eta));
    }

    size_t size() const override { return boundaries_.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const Formula& formula : formulas) {
            if (std::find(methods.begin(), methods.end(), formula.name) == methods.end()) continue;
            const auto found = std::make_shared<std::vector<double>>(size());
            result.push_back({formula.name,
                              [this, found, formula] {
                                  for (size_t i = 0; i < size(); ++i)
                                      (*found)[i] = formula.reflectance(boundaries_[i]);
                              },
                              [found](size_t i) {
                                  MethodAnswer answer;
                                  answer.t = (*found)[i];
                                  if (answer.t < 1) answer.hit.geometry = 0;
                                  return answer;
                              }});
        }
        return result;
    }

    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        if (bool(answer.hit) == hits(i)) return Verdict::same;
        // Close to the critical angle the reflectance itself rounds to one.
        if (hits(i) && truths_[i].reflectance > 1 - 0x1p-21) return Verdict::undecidable;
        if (!decidable(i)) return Verdict::undecidable;
        return hits(i) ? Verdict::missed : Verdict::false_hit;
    }

    Measures measure(size_t i, const MethodAnswer& answer) const override {
        Measures measures = no_measures;
        const double truth = truths_[i].reflectance, error = std::abs(answer.t - truth);
        const auto rounded = static_cast<float>(truth);
        measures[static_cast<size_t>(Measure::t_ulps)] =
            error / static_cast<double>(std::nextafter(rounded, INFINITY) - rounded);
        const double moved = change_by_an_ulp(i);
        if (moved > 0) measures[static_cast<size_t>(Measure::stability)] = 2 * error / moved;
        return measures;
    }

    bool hits(size_t i) const override { return !truths_[i].total; }
    double condition(size_t i) const override {
        return change_by_an_ulp(i) / truths_[i].reflectance * 0x1p23;
    }
    bool decidable(size_t i) const override {
        bool same = true;
        visit_neighbours(i, [&](const ExactRefraction& r) { same &= r.total == truths_[i].total; });
        return same;
    }

  private:
    template <class Visit>
    void visit_neighbours(size_t i, const Visit& visit) const {
        const auto [c, n] = boundaries_[i];
        for (const float end : {-INFINITY, INFINITY}) {
            visit(exact_refraction(std::clamp(std::nextafter(c, end), 0.0f, 1.0f), n));
            visit(exact_refraction(c, std::nextafter(n, end)));
        }
    }
    double change_by_an_ulp(size_t i) const {
        double change = 0;
        visit_neighbours(i, [&](const ExactRefraction& r) {
            change = std::max(change, std::abs(r.reflectance - truths_[i].reflectance));
        });
        return change;
    }

    std::vector<Boundary> boundaries_;
    std::vector<ExactRefraction> truths_;
};

/// cos²t = ±1/knob: just short of total reflection, or just beyond.
Boundary near_critical(double knob, Dice& dice) {
    const auto eta = static_cast<float>(1 / dice.between(1.05, 2.5));
    const double n = static_cast<double>(eta), squared = dice.sign() / knob;
    return {static_cast<float>(std::sqrt(std::clamp(1 - n * n * (1 - squared), 0.0, 1.0))), eta};
}

Boundary grazing(double knob, Dice& dice) {
    const auto eta = static_cast<float>(dice.between(1.05, 2.5));
    return {static_cast<float>(dice.between(0.5, 1) / knob), eta};
}

}  // namespace

void add_refraction_families(std::vector<Family>& families) {
    std::vector<std::string> methods;
    for (const Formula& formula : formulas) methods.push_back(formula.name);
    families.push_back({"R1", "refraction close to the critical angle",
                        "1 / squared cosine of refraction", powers(10, 0, 9), methods,
                        trials_of<RefractionTrial>(near_critical)});
    families.push_back({"R2", "refraction at grazing incidence", "1 / cosine", powers(10, 0, 9),
                        methods, trials_of<RefractionTrial>(grazing)});
}

}  // namespace sightline
