#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coding/coefficient_planes.hpp"
#include "coding/detail_code.hpp"
#include "model/detail_model.hpp"
#include "model/term_basis.hpp"

namespace mien::decoder {

/// The texels of a mask blob, found on the model's mesh.
struct DetailDomain {
    std::uint32_t texels = 0;          ///< of the mask
    model::DomainMap map;
    std::vector<std::uint32_t> rank;   ///< of the map's texels among the mask's
    std::optional<coding::MaskedWavelet> wavelet;
};

/// A polynomial map that has begun.
class DetailLayer {
public:
    DetailLayer(std::string name, std::shared_ptr<const DetailDomain> domain, const coding::MapHead& head);

    const DetailDomain& domain() const { return *domain_; }
    const std::shared_ptr<const DetailDomain>& shared_domain() const { return domain_; }
    int stages() const { return stages_; }          ///< that have been taken
    bool complete() const { return stages_ == head_.stages; }

    Result<void> take(const coding::MapStage& stage);
    /// The map as far as it is known.
    Result<model::PolynomialMap> map(const std::vector<Triangle>& marker_triangles, const model::TermFactors& factors) const;

private:
    std::string name_;
    std::shared_ptr<const DetailDomain> domain_;
    coding::MapHead head_;
    coding::CoefficientPlanes values_;
    std::array<std::int8_t, 2> lift_{};
    int stages_ = 0;
};

}  // namespace mien::decoder
