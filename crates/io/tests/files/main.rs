//! Files written by the tests themselves, damaged ones, and real ones.

#[path = "../damage/mod.rs"]
mod damage;
mod damaged;
mod images;
mod make;
mod mutations;
mod real;
mod round_trips;
