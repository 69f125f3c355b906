//! Macro for the table of particle columns.
//!
//! One line of the table states name, type, value of one particle, name in a checkpoint, when the
//! column is in use and how it is sorted. The macro generates [`ParticleArrays`] and
//! [`ParticleRow`] with everything that has to name every column, so that a column cannot be
//! forgotten.
//!
//! [`ParticleArrays`]: super::arrays::ParticleArrays
//! [`ParticleRow`]: super::rows::ParticleRow

/// Condition for a column to be in use; unused columns are empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum When {
    /// Always.
    Always,
    /// The pressure evolves by an equation of its own.
    PressureEvolves,
    /// Particles are moved by more than their velocity.
    ParticlesDrift,
    /// A wall particle has been added.
    WallsExist,
    /// A particle of a thin wall, each side of which has fluid of its own, has been added.
    WallsAreThin,
}

impl When {
    /// All conditions in their order.
    pub(super) const ALL: [When; 5] =
        [When::Always, When::PressureEvolves, When::ParticlesDrift, When::WallsExist, When::WallsAreThin];
}

/// Treatment of a column when the particles are sorted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sort {
    /// Its values are permuted.
    Permute,
    /// Its values are permuted unless all are equal, such as the zones in a box of fluid.
    PermuteUnlessUniform,
    /// Its values are permuted if there are walls; otherwise all are equal.
    PermuteIfWalls,
}

/// Generates the columns of the particles from their table.
macro_rules! columns {
    ($(
        $(#[$doc:meta])*
        $name:ident: $column:ty => $value:ty, $saved:literal, $when:ident, $sort:ident($spare:ident);
    )*) => {
        /// Columns of all particles that can be a neighbour, in `D` dimensions.
        ///
        /// Positions are f64 always; the other columns are in the precision of the pair sums.
        #[derive(Clone, Debug)]
        pub struct ParticleArrays<R: Real, const D: usize> {
            $(
                $(#[$doc])*
                pub $name: $column,
            )*
            /// Rate of change of velocity, m/s²: written by a step between its sort and its kick,
            /// without meaning at other times.
            pub acceleration: [Vec<R>; D],
            /// True if the pressure evolves by an equation of its own.
            pub evolves_pressure: bool,
            /// True if particles are moved by more than their velocity.
            pub drifts: bool,
        }

        /// All values of one particle.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct ParticleRow {
            $(
                $(#[$doc])*
                pub $name: $value,
            )*
        }

        impl<R: Real, const D: usize> Default for ParticleArrays<R, D> {
            fn default() -> Self {
                Self {
                    $($name: Quantity::empty(),)*
                    acceleration: Quantity::empty(),
                    evolves_pressure: false,
                    drifts: false,
                }
            }
        }

        impl<R: Real, const D: usize> ParticleArrays<R, D> {
            /// Appends a particle behind all others, outside the order of the cells, until the next
            /// sort.
            pub fn push(&mut self, particle: &ParticleRow) {
                let row = self.len();
                $(
                    if self.is_used(When::$when) || When::$when.begins_with(particle) {
                        Quantity::push(&mut self.$name, row, particle.$name);
                    }
                )*
                Quantity::push(&mut self.acceleration, row, Default::default());
            }

            /// Appends particles as [`Self::push`] does, column by column.
            pub fn extend(&mut self, particles: &[ParticleRow]) {
                let first = self.len();
                let used = When::ALL.map(|when| self.is_used(when));
                rayon::scope(|tasks| {
                    $(
                        let is_used = used[When::$when as usize];
                        let column = &mut self.$name;
                        tasks.spawn(move |_| {
                            let begins = |row: &ParticleRow| is_used || When::$when.begins_with(row);
                            let begin = particles.iter().position(begins).unwrap_or(particles.len());
                            // Rows before the one that brings a column into use have its default.
                            for (at, particle) in particles.iter().enumerate().skip(begin) {
                                Quantity::push(column, first + at, particle.$name);
                            }
                        });
                    )*
                    for column in &mut self.acceleration {
                        column.resize(first + particles.len(), R::default());
                    }
                });
            }

            /// Writes all values of the particle of a row, except to columns that are not in use.
            pub fn set(&mut self, row: usize, particle: &ParticleRow) {
                $(
                    if self.is_used(When::$when) {
                        Quantity::set(&mut self.$name, row, particle.$name);
                    }
                )*
            }

            /// Returns arrays of a number of particles with the same columns in use, but without
            /// accelerations; all values are the defaults.
            pub(crate) fn of_same_columns(&self, rows: usize) -> Self {
                let mut arrays = Self {
                    evolves_pressure: self.evolves_pressure,
                    drifts: self.drifts,
                    ..Self::default()
                };
                $(
                    if self.is_used(When::$when) {
                        let columns = arrays.$name.columns_mut();
                        columns.iter_mut().for_each(|column| *column = vec![Default::default(); rows]);
                    }
                )*
                arrays
            }

            /// Returns some rows, without accelerations and without memory for more.
            pub fn of_rows(&self, rows: &[u32]) -> Self {
                let mut arrays = self.of_same_columns(0);
                let picked = SavedRows::of(rows);
                $(
                    if self.is_used(When::$when) {
                        let columns = self.$name.columns().iter().zip(arrays.$name.columns_mut());
                        columns.for_each(|(from, to)| *to = picked.pick(from));
                    }
                )*
                arrays.acceleration = std::array::from_fn(|_| vec![R::default(); rows.len()]);
                arrays
            }

            /// Changes the number of particles; new ones have the defaults of all columns in use.
            pub fn resize(&mut self, rows: usize) {
                $(
                    if self.is_used(When::$when) {
                        let columns = self.$name.columns_mut();
                        columns.iter_mut().for_each(|column| column.resize(rows, Default::default()));
                    }
                )*
                self.acceleration.iter_mut().for_each(|column| column.resize(rows, R::default()));
            }

            /// Returns all values of the particle of a row; 0 for columns that are not in use.
            pub fn row(&self, row: usize) -> ParticleRow {
                ParticleRow {
                    $(
                        $name: match self.is_used(When::$when) {
                            true => self.$name.value(row),
                            false => Default::default(),
                        },
                    )*
                }
            }

            /// Reserves memory for that many more particles, and no more.
            pub fn reserve(&mut self, particles: usize) {
                $(
                    if self.is_used(When::$when) {
                        self.$name.columns_mut().iter_mut().for_each(|column| column.reserve_exact(particles));
                    }
                )*
                self.acceleration.iter_mut().for_each(|column| column.reserve_exact(particles));
            }

            /// Empties every column, keeping its memory.
            pub fn clear(&mut self) {
                $(self.$name.columns_mut().iter_mut().for_each(Vec::clear);)*
                self.acceleration.iter_mut().for_each(Vec::clear);
            }

            /// Reverses the order of the rows.
            pub fn reverse(&mut self) {
                $(self.$name.columns_mut().iter_mut().for_each(|column| column.reverse());)*
                self.acceleration.iter_mut().for_each(|column| column.reverse());
            }

            /// Puts the rows of every column into `order`.
            fn reorder_columns(&mut self, order: &[u32], spare: &mut SpareColumns<R>) {
                let has_walls = self.is_used(When::WallsExist);
                $(reorder(&mut self.$name, Sort::$sort, has_walls, order, &mut spare.$spare);)*
                for column in &mut self.acceleration {
                    column.resize(order.len(), R::default());
                }
            }

            /// Adds every column that the next step depends on to a checkpoint, of the chosen
            /// particles.
            pub(super) fn save_columns(&self, rows: &SavedRows, to: &mut Columns) {
                $(self.$name.save(concat!("arrays.", $saved), &|column| rows.pick(column), to);)*
                to.put("arrays.evolves_pressure", vec![u8::from(self.evolves_pressure)]);
                to.put("arrays.drifts", vec![u8::from(self.drifts)]);
            }

            /// Adds the columns as [`Self::save_columns`] does, and frees each once it is added.
            pub(super) fn give_columns(mut self, rows: &SavedRows, to: &mut Columns) {
                $(
                    let column = std::mem::replace(&mut self.$name, Quantity::empty());
                    column.save(concat!("arrays.", $saved), &|column| rows.pick(column), to);
                    drop(column);
                )*
                to.put("arrays.evolves_pressure", vec![u8::from(self.evolves_pressure)]);
                to.put("arrays.drifts", vec![u8::from(self.drifts)]);
            }

            /// Takes every column of [`Self::save_columns`].
            ///
            /// # Errors
            /// [`ColumnMismatch`] when a column is missing, of another type or length, or has a
            /// wrong value.
            pub(super) fn restore_columns(from: &mut Columns) -> Result<Self, ColumnMismatch> {
                let rows = from.iter().find(|(name, _)| *name == "arrays.id").map_or(0, |(_, id)| id.len());
                let mut arrays = Self {
                    evolves_pressure: from.take_exactly::<u8>("arrays.evolves_pressure", 1)? == [1],
                    drifts: from.take_exactly::<u8>("arrays.drifts", 1)? == [1],
                    ..Self::default()
                };
                $(
                    let lengths = arrays.lengths(When::$when, rows);
                    arrays.$name = Quantity::restore(concat!("arrays.", $saved), &lengths, from)?;
                )*
                arrays.acceleration = std::array::from_fn(|_| vec![R::default(); rows]);
                Ok(arrays)
            }
        }
    };
}

pub(super) use columns;
