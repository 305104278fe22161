//! The one macro behind every table: columns in lockstep with their keys, so that no push can forget a column.

use super::order;

/// Operations that a table needs of a list beyond those of every list.
pub(super) trait Column<T> {
    /// Overwrites a row.
    fn put(&mut self, row: usize, value: T);

    /// Brings the rows into an order, which has the old place of every new one.
    fn sort(&mut self, order: &[u32]);
}

impl<T: Copy> Column<T> for Vec<T> {
    fn put(&mut self, row: usize, value: T) {
        self[row] = value;
    }

    fn sort(&mut self, order: &[u32]) {
        order::sort(order, self);
    }
}

/// Declares a table of columns and the struct of one of its rows.
macro_rules! table {
    (
        $(#[$table_doc:meta])*
        pub struct $table:ident, row $row:ident, key $key:ident {
            $( $(#[$column_doc:meta])* $column:ident: $list:ident<$type:ty>, )*
            $( ..$(#[$beside_doc:meta])* $beside:ident: $beside_type:ty, )?
        }
    ) => {
        slotmap::new_key_type! {
            #[doc = concat!("The stable key of a row of [`", stringify!($table), "`].")]
            pub struct $key;
        }

        #[doc = concat!("One row of [`", stringify!($table), "`], all columns.")]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $row {
            $( $(#[$column_doc])* pub $column: $type, )*
        }

        $(#[$table_doc])*
        #[derive(Clone, Debug, Default)]
        #[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
        pub struct $table {
            rows: crate::storage::Rows<$key>,
            $( $(#[$column_doc])* pub $column: $list<$type>, )*
            $(
                $(#[$beside_doc])*
                #[cfg_attr(feature = "snapshot", serde(skip))]
                pub(crate) $beside: $beside_type,
            )?
        }

        impl $table {
            /// Adds a row at the end and gives its key.
            pub fn push(&mut self, row: $row) -> $key {
                $( self.$column.push(row.$column); )*
                self.rows.push()
            }

            /// Takes the last row away.
            pub fn pop(&mut self) -> Option<$row> {
                self.rows.pop()?;
                Some($row { $( $column: self.$column.pop()?, )* })
            }

            /// Takes `row` away; the last row takes its place.
            pub fn swap_remove(&mut self, row: u32) -> Option<$row> {
                self.rows.swap_remove(row)?;
                Some($row { $( $column: self.$column.swap_remove(row as usize), )* })
            }

            /// As [`swap_remove`](Self::swap_remove), but the key can be exhumed until it is released.
            #[doc(hidden)]
            pub fn bury(&mut self, row: u32) -> Option<$row> {
                self.rows.bury(row)?;
                Some($row { $( $column: self.$column.swap_remove(row as usize), )* })
            }

            /// Puts a row back under the key that was buried last; the one at `row` moves to the end. `None` where no key is
            /// buried, or `row` is beyond the end.
            #[doc(hidden)]
            pub fn exhume(&mut self, row: u32, value: $row) -> Option<$key> {
                let key = self.rows.exhume(row)?;
                let last = self.rows.len() - 1;
                $( self.$column.push(value.$column); self.$column.swap(row as usize, last); )*
                Some(key)
            }

            /// Frees the buried keys, which are dead for good then.
            pub fn release(&mut self) {
                self.rows.release();
            }

            /// The buried keys, the last one last.
            pub fn buried(&self) -> &[$key] {
                self.rows.buried()
            }

            /// Brings the rows into another order; `order` has the old row of every new one. Keys go with their rows.
            ///
            /// # Panics
            /// If `order` does not have every row once.
            #[doc(hidden)]
            pub fn permute(&mut self, order: &[u32]) {
                self.rows.permute(order);
                $( crate::storage::table::Column::sort(&mut self.$column, order); )*
            }

            /// All columns of one row.
            ///
            /// # Panics
            /// If the row is not below [`len`](Self::len).
            pub fn at(&self, row: u32) -> $row {
                $row { $( $column: self.$column[row as usize], )* }
            }

            /// Overwrites all columns of one row; its key stays.
            ///
            /// # Panics
            /// If the row is not below [`len`](Self::len).
            pub fn set(&mut self, row: u32, value: $row) {
                $( crate::storage::table::Column::put(&mut self.$column, row as usize, value.$column); )*
            }

            /// The row where a living key is now.
            pub fn row(&self, key: $key) -> Option<u32> {
                self.rows.row(key)
            }

            /// The key of a row.
            pub fn key(&self, row: u32) -> Option<$key> {
                self.rows.key(row)
            }

            /// All keys, in the order of their rows.
            pub fn keys(&self) -> &[$key] {
                self.rows.keys()
            }

            /// Number of rows.
            pub fn len(&self) -> usize {
                self.rows.len()
            }

            /// Whether there are none.
            pub fn is_empty(&self) -> bool {
                self.rows.is_empty()
            }

            /// Makes room for `additional` rows in every column, and no more.
            pub fn reserve(&mut self, additional: usize) {
                self.rows.reserve(additional);
                $( self.$column.reserve_exact(additional); )*
            }

            /// The name of the first column whose length differs from the number of keys, or `"keys"` where keys and
            /// rows contradict each other.
            #[doc(hidden)]
            pub fn first_misaligned_column(&self) -> Option<&'static str> {
                if !self.rows.is_consistent() {
                    return Some("keys");
                }
                $( if self.$column.len() != self.rows.len() { return Some(stringify!($column)); } )*
                None
            }
        }
    };
}

pub(crate) use table;
