# A disassembly (objdump --demangle) in; for each function of `exported` that reaches core::panicking, the shortest way
# there out. Only direct calls and jumps are followed.

/^[0-9a-f]+ <.*>:$/ {
    name = $0
    sub(/^[0-9a-f]+ </, "", name)
    sub(/>:$/, "", name)
    next
}

/\t *(call|jmp|j[a-z]+) / && /<.*>/ {
    to = $0
    sub(/^[^<]*</, "", to)
    sub(/(\+0x[0-9a-f]+)?>[^>]*$/, "", to)
    if (to != name && !((name, to) in edge)) {
        edge[name, to]
        callees[name] = callees[name] SUBSEP to
    }
}

function way(start,    queue, head, tail, here, next_one, list, n, i, seen, path) {
    queue[tail = 1] = start
    seen[start]
    path[start] = start
    for (head = 1; head <= tail; head++) {
        here = queue[head]
        if (here ~ /core::panicking|core::slice::index::slice_|core::option::(unwrap|expect)_failed|core::result::unwrap_failed|core::cell::panic_/)
            return path[here]
        n = split(callees[here], list, SUBSEP)
        for (i = 1; i <= n; i++) {
            next_one = list[i]
            if (next_one != "" && !(next_one in seen)) {
                seen[next_one]
                path[next_one] = path[here] " -> " next_one
                queue[++tail] = next_one
            }
        }
    }
    return ""
}

END {
    n = split(exported, roots, /[ \n]+/)
    for (i = 1; i <= n; i++) {
        found = way(roots[i])
        if (found != "")
            print "  " found
    }
}
