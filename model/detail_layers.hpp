#pragma once

#include "model/detail_model.hpp"

namespace mien::model {

/// The layers of a detail model made ready to be put on a base shape, whatever that is: they follow the points of its mesh at
/// the model's marker sites.
class DetailLayers {
public:
    /// The mesh's topology and texture coordinates are the base shape's own.
    explicit DetailLayers(DetailModel model);

    const DetailModel& model() const { return model_; }
    const DeformationMeter& meter() const { return meter_; }
    const MediumSurface& medium_surface() const { return medium_surface_; }

    /// Texels of the fine map per mm of skin, on average.
    double texels_a_mm() const;

    /// d1, d2 of a formed base shape, V x 3 mm, head space.
    DomainParameters parameters(PointsRef base) const;
    /// Adds the medium layer to a base shape, V x 3 mm, head space.
    void add_medium(const DomainParameters& parameters, Points& points) const;

private:
    DetailModel model_;
    DeformationMeter meter_;
    MediumSurface medium_surface_;
};

}  // namespace mien::model
