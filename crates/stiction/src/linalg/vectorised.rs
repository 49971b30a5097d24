use pulp::{Arch, Simd, WithSimd};

/// Runs `work` with the vector instructions of the machine at hand (Kazdadi: pulp), which not every machine has that this
/// is compiled for. It is to be an `#[inline(always)]` closure, and so is what takes time in it: what stays a function of its
/// own is compiled for all machines. (So is a closure that is called as `FnOnce` and could be called twice, by way of its
/// shim; hence `FnMut`.)
#[inline(always)]
pub(crate) fn vectorised(work: impl FnMut()) {
    struct Work<F>(F);
    impl<F: FnMut()> WithSimd for Work<F> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(mut self, _: S) {
            (self.0)();
        }
    }
    Arch::new().dispatch(Work(work));
}
