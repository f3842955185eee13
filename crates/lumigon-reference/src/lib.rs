//! Truth to measure lumigon against: adaptive cubature and a path tracer in f64.
