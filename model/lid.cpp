#include "model/lid.hpp"

#include <algorithm>

namespace mien::model {

void keep_on_eyeball(const Lid& lid, const Points& neutral, Points& points) {
    for (const Lid::Member& member : lid.members) {
        const Vec3 from_centre = points.row(member.vertex).transpose() - lid.centre;
        const float rest = (neutral.row(member.vertex).transpose() - lid.centre).norm();
        points.row(member.vertex) += (member.hold * (rest / std::max(from_centre.norm(), 1e-3f) - 1) * from_centre).transpose();
    }
}

}  // namespace mien::model
