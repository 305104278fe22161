//! ParaView files.
