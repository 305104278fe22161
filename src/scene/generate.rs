//! Mesh generators.
