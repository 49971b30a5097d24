/// Arrays below this size are left as they are, bytes.
#[cfg(target_os = "linux")]
const SMALL: usize = 4 << 20;

/// Asks the system to back a large array that has not been written yet by huge pages: at a few microseconds a page the
/// first touch of gigabytes in small pages costs a third of a whole solve. Only advice; the contents are not touched.
pub fn in_huge_pages<T>(array: Vec<T>) -> Vec<T> {
    #[cfg(target_os = "linux")]
    {
        let bytes = array.capacity() * size_of::<T>();
        if bytes >= SMALL {
            let page = 4096;
            let start = (array.as_ptr() as usize).next_multiple_of(page);
            let length = (array.as_ptr() as usize + bytes).saturating_sub(start) / page * page;
            // SAFETY: the range lies within an allocation that is ours, and the advice does not change what it holds.
            unsafe {
                libc::madvise(start as *mut libc::c_void, length, libc::MADV_HUGEPAGE);
            }
        }
    }
    array
}
