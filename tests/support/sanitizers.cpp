// What sanitizers are told in every test: leaks.supp names what leaks and is not ours; and races that are the driver's.
#ifdef __SANITIZE_ADDRESS__
extern "C" const char* __lsan_default_options();
extern "C" const char* __lsan_default_options() {
  return "print_suppressions=0:suppressions=" SCREE_LEAKS;
}

// A driver that is unloaded takes along the name by which its leaks are known: none is.
extern "C" int dlclose(void*);
extern "C" int dlclose(void*) { return 0; }
#endif

#ifdef __SANITIZE_THREAD__
// llvmpipe counts who holds a fence in code that is not instrumented, and destroys its mutex with the last one.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "race_top:pthread_mutex_destroy\nrace_top:pthread_cond_destroy\n";
}
#endif
