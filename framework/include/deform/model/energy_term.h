/// Energy terms: internal forces of the surface, on jets or on tuples of nodes.
#pragma once

#include <array>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "deform/geometry/geometry.h"
#include "deform/model/normal_estimator.h"
#include "deform/model/tangent.h"
#include "deform/plugin/descriptor.h"
#include "deform/surface/sample_set.h"
#include "deform/surface/scalar_unknown.h"
#include "deform/types.h"

namespace deform {

/// What kind of lagged (Picard) operator a term offers for linearly implicit steps.
enum class Lagged : std::uint8_t {
  none,       ///< none: such steps treat the term explicitly
  symmetric,  ///< K = Kᵀ
  unsymmetric,
};

/// What a term promises; checked by the framework's tests and by `deform plugin check`.
struct TermTraits {
  bool potential = false;  ///< force = −∇energy exactly, wherever the set has one consistent frame
  Lagged lagged = Lagged::none;
  bool semidefinite = false;  ///< the lagged operator is positive semidefinite
  bool strong_form = false;   ///< needs samples that are the nodes, and FieldDifferences
  /// Is a function of G and B less those of SampleBlock::origin, and of SampleBlock::rest else:
  /// damping of the material is then that of exact strain rates over a step, and forces over a step
  /// conserve the energy where a method asks for it (Geometry::make_mean). A stress is then Σ_a S_a
  /// ∂G_a + M_a ∂B_a with S and M of now.G and now.B, and derivatives of now's jet, n and Γ.
  bool strains = false;
  /// Only for terms with a lagged operator: offers `stress` beside `affine_stress`, the same at
  /// now == lagged, which is used wherever no operator is asked for.
  bool direct_stress = false;
};

/// Internal energy of the surface.
class DEFORM_API EnergyTerm : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::energy;
  ~EnergyTerm() override;
  [[nodiscard]] virtual TermTraits traits() const = 0;
  /// Mass per area that the term's material has at each node [kg/m²] (N), which holds where the
  /// scene says no density; empty where the term knows none.
  [[nodiscard]] virtual NodeValues mass_per_area() const { return {}; }
};

/// The operators that map stress-like vectors at samples back to forces at nodes: D_0ᵀ … D_22ᵀ, and
/// for strong forms −D_1^- and −D_2^- (which D_1ᵀ and D_2ᵀ are in the interior).
enum class Channel : std::uint8_t { d0, d1, d2, d11, d12, d22, minus1, minus2 };
inline constexpr int kChannels = 8;
[[nodiscard]] constexpr int slot(Channel m) { return static_cast<int>(m); }
[[nodiscard]] constexpr Channel channel(Derivative d) { return static_cast<Channel>(d); }

/// A pair (m, n): stress σ_m depends on D_n r.
using Coupling = std::pair<Channel, Derivative>;
/// Every pair of some derivatives: σ_m depends on D_n r for all m and n of them.
[[nodiscard]] DEFORM_API std::vector<Coupling> couplings_among(
    std::initializer_list<Derivative> derivatives);

/// A block of samples as a term on jets sees it.
struct DEFORM_API SampleBlock {
  GeometryBlock now;     ///< the state at which the term is evaluated
  GeometryBlock lagged;  ///< the state that lagged coefficients come from (often the same)
  GeometryBlock rest;    ///< the rest state: G⁰ = rest.G(ij), B⁰ = rest.B(ij)
  /// What changes of G and B are measured from: the rest state, but for the damping of a material,
  /// which asks for those since an earlier state (TermTraits::strains).
  GeometryBlock origin;

  /// D^- of the term's auxiliary field f (strong form only); out has size() numbers. Throws Error
  /// where there is no such field.
  void difference(Derivative op, int f, Values out) const;

  [[nodiscard]] Index size() const { return now.size(); }
  [[nodiscard]] Index first() const { return now.first(); }

  const FieldDifferences* differences = nullptr;
  std::span<const ConstValues> auxiliary;  ///< whole fields (m)
};

/// Adds factor · Σ w_ij (T_ij − T⁰_ij)² over all four ij, the weighted norm of (17) and (18), at
/// each sample of a block: for T = G or B, `tensor` is &GeometryBlock::G or &GeometryBlock::B.
DEFORM_API void add_weighted_norm(double factor, const PairWeights& weights,
                                  const SampleBlock& block,
                                  ConstValues (GeometryBlock::*tensor)(Pair) const, Values density);

/// Stress of a block as an affine form of the jet, σ_m = Σ_n k_mn D_n r + c_m; terms add to it.
class DEFORM_API AffineStress {
 public:
  /// k_mn of the block's samples; throws Error when the term did not declare the coupling.
  [[nodiscard]] Values k(Channel m, Derivative n) const {
    double* values = k_[static_cast<std::size_t>(slot(m))][static_cast<std::size_t>(slot(n))];
    if (values == nullptr) undeclared(m, n);
    return {values, size_};
  }
  [[nodiscard]] Values k(Derivative m, Derivative n) const { return k(channel(m), n); }
  /// Constant part c_m; throws Error for a channel of the strong form that the term's traits do not
  /// promise.
  [[nodiscard]] Vectors c(Channel m) const {
    const Vectors c = c_[static_cast<std::size_t>(slot(m))];
    if (!c) undeclared(m);
    return c;
  }
  [[nodiscard]] Vectors c(Derivative m) const { return c(channel(m)); }

  using CouplingTable = std::array<std::array<double*, kDerivatives>, kChannels>;
  using ConstantTable = std::array<Vectors, kChannels>;
  AffineStress(const CouplingTable& k, const ConstantTable& c, Index size)
      : k_(k), c_(c), size_(static_cast<std::size_t>(size)) {}

 private:
  [[noreturn]] static void undeclared(Channel m, Derivative n);
  [[noreturn]] static void undeclared(Channel m);
  CouplingTable k_;
  ConstantTable c_;
  std::size_t size_;
};

/// Stress vectors of a block, one a channel; null on the strong form's channels where the term's
/// traits do not promise it.
struct Stress {
  std::array<Vectors, kChannels> sigma;
  [[nodiscard]] Vectors operator()(Derivative m) const {
    return sigma[static_cast<std::size_t>(slot(m))];
  }
};

/// An energy term that lives on jets. The force on the nodes is f = −Σ_m D_mᵀ A σ_m (A: sample
/// weights); the framework gathers it, and the operator K = Σ_mn D_mᵀ A k_mn D_n, row by row.
///
/// Contract: const and thread-safe on blocks; adds to what it is given. A term offers
/// `affine_stress` (from which the stress follows), `stress`, or both (TermTraits::direct_stress);
/// or neither: then the stress is a numerical derivative of the density, which the log says.
class DEFORM_API JetTerm : public EnergyTerm {
 public:
  ~JetTerm() override;

  [[nodiscard]] virtual SampleRole role() const { return SampleRole::bending; }

  /// Adds the energy per parameter area [J/m²] at each sample.
  virtual void energy_density(const SampleBlock& block, Values density) const = 0;

  /// Adds σ_m, the derivative of the density with respect to D_m r [N/m, N]. Default: by central
  /// differences of energy_density (relative error about 1e-9).
  virtual void stress(const SampleBlock& block, const Stress& sigma) const;

  /// The couplings that affine_stress writes; empty for terms with traits().lagged == none.
  [[nodiscard]] virtual std::vector<Coupling> couplings() const;
  /// Adds k_mn and c_m from block.lagged. Rule: at now == lagged, Σ k_mn D_n r + c_m is the stress.
  virtual void affine_stress(const SampleBlock& block, const AffineStress& sigma) const;

  /// The derivatives of the jet that the density depends on.
  [[nodiscard]] virtual std::vector<Derivative> dependence() const;
  /// What the term reads of block.now, block.lagged and block.origin; the rest of them is not a
  /// number. Default: everything, or what follows from first derivatives where the density of a
  /// potential depends on these alone and nothing else of the term says that it reads more. A term
  /// whose tangents have the normal's shape gets the normal in any case.
  [[nodiscard]] virtual Geometry::Detail reads() const;
  /// Adds the second derivatives of the density at block.now. Terms without a potential are asked
  /// for the projected ones alone: an approximation, positive semidefinite, of their stress's
  /// derivative, with which implicit steps precondition; those of the strong form are asked where
  /// their tangents have the normal's shape.
  /// Default: central differences of the stress, made positive semidefinite by their spectrum
  /// where that is asked for.
  virtual void tangent(const SampleBlock& block, Tangent kind, const JetTangent& h) const;
  /// What tangents of that kind are, for all m and n, with the normal of block.now. Default:
  /// blocks.
  [[nodiscard]] virtual TangentShape tangent_shape(Tangent kind) const;
  /// Adds the factors c_mn of tangents of a shape that is not `blocks`; asked for instead of
  /// `tangent` wherever all terms of a sample set have the same shape.
  virtual void tangent_factors(const SampleBlock& block, Tangent kind,
                               const TangentFactors& c) const;

  /// Number of sample fields that `auxiliary` computes and affine_stress differences (strong form).
  [[nodiscard]] virtual int auxiliary_fields() const { return 0; }
  virtual void auxiliary(const SampleBlock& block, std::span<const Values> fields) const;

  /// The estimator that the term uses, if any (for probes and outputs).
  [[nodiscard]] virtual const NormalEstimator* normal() const { return nullptr; }
};

/// A block of node tuples: positions r(i, a) of the a-th node of tuple i, or (s, 0, 0) where that
/// is a scalar unknown s.
struct TupleBlock {
  Index first = 0;
  Index size = 0;
  int width = 0;                        ///< nodes a tuple
  const std::int32_t* nodes = nullptr;  ///< (size × width), row-major
  const NodeVectors* now = nullptr;
  const NodeVectors* lagged = nullptr;

  [[nodiscard]] Index node(Index i, int a) const { return nodes[i * width + a]; }
  [[nodiscard]] Vec3 r(Index i, int a) const { return position(*now, node(i, a)); }
  [[nodiscard]] Vec3 r_lagged(Index i, int a) const { return position(*lagged, node(i, a)); }

 private:
  [[nodiscard]] static Vec3 position(const NodeVectors& r, Index node) {
    return {r(node, 0), r(node, 1), r(node, 2)};
  }
};

/// An energy term on tuples of nodes (springs, hinges): f_a = −Σ_b k_ab r_b − c_a for each tuple.
///
/// Contract as JetTerm's: const, thread-safe on blocks, adds.
class DEFORM_API TupleTerm : public EnergyTerm {
 public:
  ~TupleTerm() override;

  /// Nodes a tuple.
  [[nodiscard]] virtual int width() const = 0;
  /// The term's own scalar unknowns; fixed for the object's life. Default: none.
  [[nodiscard]] virtual std::vector<ScalarUnknown> scalars() const;
  /// (T × width) node numbers, row-major; fixed for the object's life. Behind the nodes come the
  /// surface's scalar unknowns (Surface::scalars), which terms share, then the term's own.
  [[nodiscard]] virtual const std::vector<std::int32_t>& tuples() const = 0;
  /// Adds the energy [J] of each tuple.
  virtual void energy(const TupleBlock& block, Values energy) const = 0;
  /// Adds to k (size × width × width, row-major) [N/m] and c (size × width) [N] from the lagged
  /// positions. Rule: at now == lagged, −Σ_b k_ab r_b − c_a is the force.
  virtual void affine_force(const TupleBlock& block, Values k, std::span<Vec3> c) const = 0;
  /// Adds to h (size × 3·width × 3·width, row-major) [N/m] the second derivatives of each tuple's
  /// energy; only for terms with a potential. Default: central differences of the force, made
  /// positive semidefinite by their spectrum where that is asked for.
  virtual void tangent(const TupleBlock& block, Tangent kind, Values h) const;
};

/// An energy term that is a sum of others, each with its own sample set: stretching and bending of
/// one material, say. The framework takes the parts for terms of the scene, under the compound's
/// name, '_' and theirs.
class DEFORM_API CompoundTerm : public EnergyTerm {
 public:
  struct Part {
    std::string name;  ///< [a-z][a-z0-9_]*
    std::shared_ptr<EnergyTerm> term;
  };
  ~CompoundTerm() override;
  /// The same objects at every call.
  [[nodiscard]] virtual const std::vector<Part>& parts() const = 0;
  /// A sum promises what its parts do; nothing asks the sum.
  [[nodiscard]] TermTraits traits() const final { return {}; }
};

}  // namespace deform
