//! mlp
#![no_std]
