//! Fits BRDFs with linearly transformed cosines.
