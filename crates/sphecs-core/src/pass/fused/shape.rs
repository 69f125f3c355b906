//! Shapes of the fused pair loop: the terms that a variant of it is compiled with.
//!
//! A loop of a fixed shape has no branches for terms that it does not use: they would keep half of
//! its sums out of the registers. Each shape is compiled for every kernel, instruction set,
//! precision and dimension; combinations that no shape names run by [`General`].

/// Terms of a pair loop that are known when it is compiled.
pub(in crate::pass) trait LoopShape {
    /// True if the terms and columns are those of the shape. Otherwise they are those of the scene,
    /// and the other constants, except the moments, do not count.
    const FIXED: bool = true;
    /// Particle noise is damped.
    const DAMPED: bool = false;
    /// Some neighbours are wall particles.
    const WALLS: bool = false;
    /// The drift correction subtracts the mean of the neighbourhood from the shifting vector.
    const CORRECTS_DRIFT: bool = false;
    /// The pressure part and the moment are summed separately, for the force on a body.
    const WITH_MOMENTS: bool = false;
    /// Shape for particles without a wall in their support.
    type AwayFromWalls: LoopShape;
}

/// Declares shapes that differ from the default by some constants.
macro_rules! shapes {
    ($($(#[$doc:meta])* $name:ident / $away:ident { $($constant:ident = $value:expr),* })*) => { $(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(in crate::pass) struct $name;

        impl LoopShape for $name {
            $(const $constant: bool = $value;)*
            type AwayFromWalls = $away;
        }
    )* };
}

shapes! {
    /// Fluid without walls.
    Plain / Plain {}
    /// Fluid and walls.
    PlainWithWalls / Plain { WALLS = true }
    /// Fluid without walls, particle noise damped.
    Damped / Damped { DAMPED = true }
    /// Fluid and walls, particle noise damped.
    DampedWithWalls / Damped { DAMPED = true, WALLS = true }
    /// Fluid and walls, particle noise damped, drift of the shifting corrected.
    DampedWithWallsDriftCorrected / DampedWithWallsDriftCorrected {
        DAMPED = true, WALLS = true, CORRECTS_DRIFT = true
    }
    /// All terms that a scene may have.
    General / General { FIXED = false }
    /// All terms, with the pressure part and the moment apart.
    GeneralWithMoments / GeneralWithMoments { FIXED = false, WITH_MOMENTS = true }
}
