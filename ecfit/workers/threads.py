"""The environment of one compute thread."""

# Read by the libraries when they load. PJRT_NPROC sizes XLA's pools, those of the compiler too; the flags
# --xla_cpu_multi_thread_eigen=false and intra_op_parallelism_threads=1 leave them as they are (JAX 0.10).
ONE_THREAD = {
    name: "1"
    for name in (
        "OPENBLAS_NUM_THREADS",
        "OMP_NUM_THREADS",
        "MKL_NUM_THREADS",
        "BLIS_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "PJRT_NPROC",
    )
}
