//! Hands: E0425 and on, E0540 and on.
