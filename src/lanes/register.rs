//! What all types made of x86 registers have in common. Every block is safe for the reason at the top of `x86`.

/// Arithmetic of a type, register by register.
macro_rules! operators {
    ($of:ident $registers:tt: Neg $xor:ident $set:ident; $($trait:ident $name:ident $does:ident)*) => {
        $(operator!($of $registers: $trait $name $does);)*
        negative!($of $registers: $xor $set);
    };
}

macro_rules! operator {
    ($of:ident ($($register:tt)+): $trait:ident $name:ident $does:ident) => {
        impl $trait for $of {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: see the top of the file.
                Self($(unsafe { $does(self.$register, other.$register) }),+)
            }
        }
    };
}

macro_rules! negative {
    ($of:ident ($($register:tt)+): $xor:ident $set:ident) => {
        impl Neg for $of {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: see the top of the file.
                Self($(unsafe { $xor(self.$register, $set(-0.0)) }),+)
            }
        }
    };
}

/// Lanes in one register: from memory, to memory, multiply-adds and the larger and smaller of two.
macro_rules! one_register {
    ($number:ident: $set:ident $load:ident $store:ident $fma:ident $fnma:ident $max:ident $min:ident) => {
        #[inline(always)]
        fn splat(x: f64) -> Self {
            Self::all(x as $number)
        }
        #[inline(always)]
        fn all(x: $number) -> Self {
            // SAFETY: see the top of the file.
            Self(unsafe { $set(x) })
        }
        #[inline(always)]
        unsafe fn load(from: *const $number) -> Self {
            // SAFETY: see the top of the file, and the caller's promise.
            Self(unsafe { $load(from) })
        }
        #[inline(always)]
        unsafe fn store(self, to: *mut $number) {
            // SAFETY: see the top of the file, and the caller's promise.
            unsafe { $store(to, self.0) }
        }
        #[inline(always)]
        fn fma(self, b: Self, c: Self) -> Self {
            // SAFETY: see the top of the file.
            Self(unsafe { $fma(self.0, b.0, c.0) })
        }
        #[inline(always)]
        fn fnma(self, b: Self, c: Self) -> Self {
            // SAFETY: see the top of the file.
            Self(unsafe { $fnma(self.0, b.0, c.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: see the top of the file.
            Self(unsafe { $max(self.0, other.0) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: see the top of the file.
            Self(unsafe { $min(self.0, other.0) })
        }
    };
}

/// [`super::Real::apart`] for some instructions, and the memory of all lanes.
macro_rules! lanes_of {
    ($features:tt) => {
        #[inline(always)]
        fn store_lanes(self, to: &mut Self::Lanes) {
            // SAFETY: there is a number a lane.
            unsafe { self.store(to.as_mut_ptr()) }
        }
        #[cold]
        #[inline(never)]
        #[target_feature(enable = $features)]
        unsafe fn apart<T: Apart<Self>>(task: T) -> T::Result {
            // SAFETY: the caller's promise.
            unsafe { task.carry_out() }
        }
    };
}

/// Eights of a type that is one: the same in another place.
macro_rules! one_eight {
    () => {
        #[inline(always)]
        fn join([eight, _]: [Self; 2]) -> Self {
            eight
        }
        #[inline(always)]
        fn load_eight(from: &Batch) -> Self {
            // SAFETY: eight numbers.
            unsafe { Self::load(from.as_ptr()) }
        }
        #[inline(always)]
        fn store_eight(eight: Self, to: &mut Batch) {
            eight.store_lanes(to);
        }
    };
}
