//! The whole way: from a case to a certified answer.
