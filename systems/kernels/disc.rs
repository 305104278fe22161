//! disc
