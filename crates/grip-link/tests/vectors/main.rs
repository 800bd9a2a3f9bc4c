//! The vectors that every peer of the link reads: protocol/vectors/valid.tsv and invalid.tsv.

#[cfg(test)]
mod fields;
#[cfg(test)]
mod invalid;
#[cfg(test)]
mod table;
#[cfg(test)]
mod valid;
