//! What a body can carry.
