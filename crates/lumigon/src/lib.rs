//! Light from polygons, exactly: irradiance, solid angle and linearly transformed cosines of any planar polygon.
